//! The second source mode of a dataset: surface samples as lights (paper, 4.1), and cuts of what each vertex sees of them.
//!
//! A source is a small disc of surface; its light is its radiosity, so that one merge at a pixel gathers a bounce. The
//! value of a vertex's cut at a node is the mean over the node's sources of the solid angle that the vertex sees of each,
//! zero where it is hidden (`<V G>` of the paper, 3).

mod near_field;

pub use near_field::{NearField, OWNED_WITHIN, Origin, owners};

use crate::{cut::packed::PackedCuts, surfel::Surfel};
use glam::Vec3;

/// A surface sample that sends light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Where it is.
    pub surfel: Surfel,
    /// Area in m² that it stands for.
    pub area: f32,
    /// How far sources are apart here, in metres: the radius of its Poisson disk.
    pub spacing: f32,
}

impl Source {
    /// Solid angle in steradians that the source fills seen from a place `from`, in front of it and with nothing between;
    /// 0 from behind.
    ///
    /// `A cos θ / (d² + A / 2π)`: right from afar, and a hemisphere at most from near by.
    #[inline(always)]
    pub fn solid_angle_from(&self, from: Vec3) -> f32 {
        let to_place = from - self.surfel.position;
        let distance_sq = to_place.length_squared();
        let height = to_place.dot(self.surfel.normal);
        if !(height > 0.0 && self.area > 0.0) {
            return 0.0;
        }
        let cosine = height / distance_sq.sqrt();
        self.area * cosine / (distance_sq + self.area * (1.0 / LARGEST_SOLID_ANGLE))
    }
}

/// Sources, what vertices see of them, and what they see of the environment.
#[derive(Clone, Debug)]
pub struct IndirectBake {
    /// `2^H` sources in the order of the leaves of their complete binary tree.
    pub sources: Vec<Source>,
    /// One cut a vertex over the sources; values are coded by [`solid_angle_code`].
    pub cuts: PackedCuts,
    /// One cut a source over the dataset's light tree: its visibility of the environment.
    pub environment_cuts: PackedCuts,
}

/// Largest solid angle that a source can fill, in steradians: a hemisphere.
pub const LARGEST_SOLID_ANGLE: f32 = 2.0 * std::f32::consts::PI;
/// Binary orders of magnitude that the code spans; what is smaller counts as hidden.
const ORDERS: f32 = 30.0;
const CODES: f32 = 4094.0;

/// A solid angle in 12 bits: 0 for none, else logarithmic, in steps of half a percent.
pub fn solid_angle_code(steradians: f32) -> u16 {
    if !(steradians > LARGEST_SOLID_ANGLE * (-ORDERS).exp2()) {
        return 0;
    }
    let orders = (steradians / LARGEST_SOLID_ANGLE).min(1.0).log2() + ORDERS;
    1 + (orders * (CODES / ORDERS) + 0.5) as u16
}

/// The solid angle in steradians of a code.
#[inline(always)]
pub fn solid_angle(code: u16) -> f32 {
    if code == 0 { 0.0 } else { LARGEST_SOLID_ANGLE * (f32::from(code - 1) * (ORDERS / CODES) - ORDERS).exp2() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angles_keep_half_a_percent() {
        assert_eq!((solid_angle_code(0.0), solid_angle_code(f32::NAN), solid_angle(0)), (0, 0, 0.0));
        assert_eq!(solid_angle_code(100.0), 4095, "no code leaves the 12 bits");
        let mut x = 1.1e-8;
        while x < LARGEST_SOLID_ANGLE {
            assert!((solid_angle(solid_angle_code(x)) / x - 1.0).abs() < 2.7e-3, "{x}");
            x *= 1.07;
        }
    }

    #[test]
    fn solid_angles_are_near_those_of_discs_at_any_distance() {
        let disc = Source {
            surfel: Surfel { position: Vec3::new(1.0, 2.0, 3.0), normal: Vec3::Y, place: Default::default() },
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
