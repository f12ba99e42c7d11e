//! Points that gather and send light, on any kind of surface.

mod ball_grid;
pub mod distance;
mod graded_grid;

pub use graded_grid::GradedGrid;

use crate::{bounds::Bounds, offset};
use glam::{Vec2, Vec3};

/// Place of a surface point on a mesh, for its material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshPlace {
    /// Index of the triangle, or of another element of the surface.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub barycentric: Vec2,
}

/// A point of a surface, seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surfel {
    /// Position in meters.
    pub position: Vec3,
    /// Unit geometric normal on the visible side.
    pub normal: Vec3,
    /// Place for the material.
    pub place: MeshPlace,
}

impl Default for Surfel {
    /// A point at the origin that faces up.
    fn default() -> Self {
        Self { position: Vec3::ZERO, normal: Vec3::Y, place: MeshPlace::default() }
    }
}

/// The scene as light transport sees it: ray casts and reflectance (meshless basis paper, 5.1).
pub trait Surface: Sync {
    /// The first surface along a ray, with its normal toward the ray's origin. The origin lies off any surface, see
    /// [`Self::offset`]. `None` also for the back of a one-sided surface.
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel>;

    /// [`Self::first_hit`] for many rays from one origin; faster for eights of nearby directions.
    fn first_hits(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[Option<Surfel>; 8]> {
        directions.iter().map(|eight| eight.map(|direction| self.first_hit(origin, direction))).collect()
    }

    /// Whether the segment between two points off all surfaces is unblocked.
    fn sees(&self, from: Vec3, to: Vec3) -> bool;

    /// Diffuse reflectance, 0 to 1 per channel.
    fn reflectance(&self, at: &Surfel) -> Vec3;

    /// A box around the scene.
    fn bounds(&self) -> Bounds;

    /// Distance of ray origins from a surface, in meters.
    fn offset(&self) -> f32 {
        offset::TRANSPORT * self.bounds().diagonal()
    }
}
