//! The distance from a basis function's point (meshless paper, Eq. 10): it grows faster off the tangent plane.

use glam::Vec3;

/// How much faster (`F_squash` of the meshless paper): iso-surfaces are ellipsoids, `1 + SQUASH` times thinner along the
/// normal.
pub const SQUASH: f32 = 2.0;

/// Square of the distance of a point that lies at `offset` from a basis function's point with unit normal `normal`.
#[inline(always)]
pub fn squashed_distance_sq(offset: Vec3, normal: Vec3) -> f32 {
    let along = offset.dot(normal);
    offset.length_squared() + (2.0 * SQUASH + SQUASH * SQUASH) * along * along
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_distance_as_printed() {
        let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let offset = Vec3::new(0.3, -0.8, 0.1);
        let printed = (offset + SQUASH * offset.dot(normal) * normal).length_squared();
        assert!((squashed_distance_sq(offset, normal) - printed).abs() < 1e-6);
        assert!((squashed_distance_sq(normal, normal) - 9.0).abs() < 1e-5, "three times as far along the normal");
    }
}
