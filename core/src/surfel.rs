//! Points of surfaces that gather and send light, whatever the kind of surface.

mod ball_grid;
pub mod distance;
mod graded_grid;

pub use graded_grid::GradedGrid;

use crate::{bounds::Bounds, offset};
use glam::{Vec2, Vec3};

/// Where on a mesh a surface point lies, to look its material up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshPlace {
    /// Index of the triangle, or of whatever else the surface is made of.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub barycentric: Vec2,
}

/// A point of a surface, seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surfel {
    /// In meters.
    pub position: Vec3,
    /// Unit geometric normal on the side that it is seen from.
    pub normal: Vec3,
    /// For its material.
    pub place: MeshPlace,
}

impl Default for Surfel {
    /// At the origin, facing up.
    fn default() -> Self {
        Self { position: Vec3::ZERO, normal: Vec3::Y, place: MeshPlace::default() }
    }
}

/// All that light transport needs of a scene: ray casts and reflectance (meshless basis paper, 5.1).
pub trait Surface: Sync {
    /// The first surface along a ray, with its normal on the side of the ray's origin. The origin lies off any surface,
    /// see [`Self::offset`]. `None` also for the back of a surface that is seen from one side only.
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel>;

    /// [`Self::first_hit`] of many rays from one origin, faster the nearer the directions of eight are to each other.
    fn first_hits(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[Option<Surfel>; 8]> {
        directions.iter().map(|eight| eight.map(|direction| self.first_hit(origin, direction))).collect()
    }

    /// Whether nothing lies between two points that are off all surfaces.
    fn sees(&self, from: Vec3, to: Vec3) -> bool;

    /// Diffuse reflectance, 0 to 1 per channel.
    fn reflectance(&self, at: &Surfel) -> Vec3;

    /// A box around all of it.
    fn bounds(&self) -> Bounds;

    /// Distance in meters that rays start off a surface.
    fn offset(&self) -> f32 {
        offset::TRANSPORT * self.bounds().diagonal()
    }
}
