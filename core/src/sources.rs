//! The second source mode of a dataset: surface samples as lights (paper, 4.1), and each vertex's cut over them.
//!
//! A source is a small disc of surface. Its light is its radiosity, so one merge at a pixel gathers one bounce. The
//! value of a vertex's cut at a node is the mean solid angle of the node's sources seen from the vertex, zero for
//! hidden sources (`<V G>` of the paper, 3).

mod light;
mod near_field;
mod tree;

pub use near_field::{NearField, OWNED_WITHIN, Origin, owners};
pub use tree::SourceTree;

use crate::{
    cut::{LARGEST_SOLID_ANGLE, packed::PackedCuts},
    surfel::Surfel,
};
use glam::Vec3;

/// A surface sample that emits light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Position and normal.
    pub surfel: Surfel,
    /// Area in m² that it represents.
    pub area: f32,
    /// Distance between sources at this place, in meters: the radius of its Poisson disk.
    pub spacing: f32,
}

impl Source {
    /// Whether light of the source reaches `from` in free space.
    #[inline(always)]
    pub fn faces(&self, from: Vec3) -> bool {
        (from - self.surfel.position).dot(self.surfel.normal) > 0.0 && self.area > 0.0
    }

    /// Solid angle in steradians of the source seen from `from` in free space; 0 from behind.
    ///
    /// `A cos θ / (d² + A / 2π)` is exact at large distances, and at most a hemisphere at small ones.
    #[inline(always)]
    pub fn solid_angle_from(&self, from: Vec3) -> f32 {
        if !self.faces(from) {
            return 0.0;
        }
        let to_place = from - self.surfel.position;
        let distance_sq = to_place.length_squared();
        let cosine = to_place.dot(self.surfel.normal) / distance_sq.sqrt();
        self.area * cosine / (distance_sq + self.area * (1.0 / LARGEST_SOLID_ANGLE))
    }
}

/// Surface sources, the vertices' cuts over them, and the sources' cuts over the environment.
#[derive(Clone, Debug)]
pub struct IndirectBake {
    /// `2^H` sources in the order of the leaves of their complete binary tree.
    pub sources: Vec<Source>,
    /// One cut per vertex over the sources; values are coded by [`crate::cut::solid_angle_code`].
    pub cuts: PackedCuts,
    /// One cut per source over the dataset's light tree: its visibility of the environment.
    pub environment_cuts: PackedCuts,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angles_are_near_those_of_discs_at_any_distance() {
        let disc = Source {
            surfel: Surfel { position: Vec3::new(1.0, 2.0, 3.0), ..Default::default() },
            area: 0.25 * std::f32::consts::PI,
            spacing: 0.5,
        };
        let radius = 0.5_f32;
        for distance in [1e-4_f32, 0.1, 0.3, 0.5, 1.0, 3.0, 30.0] {
            let exact = LARGEST_SOLID_ANGLE * (1.0 - distance / distance.hypot(radius));
            let found = disc.solid_angle_from(disc.surfel.position + Vec3::Y * distance);
            let bound = if distance > 2.0 { 0.02 } else { 0.3 };
            assert!((found / exact - 1.0).abs() < bound, "{found} for {exact} at {distance}");
            assert!(found <= LARGEST_SOLID_ANGLE);
        }
        let far = disc.solid_angle_from(disc.surfel.position + Vec3::new(30.0, 30.0, 0.0));
        assert!((far / (disc.area * 0.5_f32.sqrt() / 1800.0) - 1.0).abs() < 1e-3, "from the side");
        assert_eq!(disc.solid_angle_from(disc.surfel.position - Vec3::Y), 0.0, "from behind");
        assert_eq!(disc.solid_angle_from(disc.surfel.position), 0.0);
        assert_eq!(Source { area: 0.0, ..disc }.solid_angle_from(Vec3::splat(9.0)), 0.0, "no area");
    }
}
