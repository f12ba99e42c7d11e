//! Points and frames on the unit sphere.

pub mod concentric;
pub mod harmonics;
pub mod octahedron;

use glam::{Mat3, Vec3};
use std::f32::consts::{PI, TAU};

/// `(√5 − 1) / 2`: steps by this share of a turn fill the turn evenly, for any number of steps.
pub const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;
/// [`GOLDEN_SECTION`] in single precision.
pub const GOLDEN_TURN: f32 = 0.618_034;

/// Solid angle of the whole sphere in steradians.
pub const SPHERE: f32 = 4.0 * PI;

/// The `i`-th of `n` spherical Fibonacci points: nearly uniform, each with solid angle `4π / n`.
pub fn fibonacci_direction(i: usize, n: usize) -> Vec3 {
    let y = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
    let phi = std::f64::consts::TAU * (i as f64 * GOLDEN_SECTION).fract();
    let r = (1.0 - y * y).max(0.0).sqrt();
    Vec3::new((r * phi.sin()) as f32, y as f32, (r * phi.cos()) as f32)
}

/// All `n` spherical Fibonacci points.
pub fn fibonacci_directions(n: usize) -> Vec<Vec3> {
    (0..n).map(|i| fibonacci_direction(i, n)).collect()
}

/// Inverse concentration of a lobe of directions of this solid angle in steradians: that of a disc with the same mean cosine.
pub const fn inv_kappa_of(solid_angle: f32) -> f32 {
    solid_angle / (2.0 * TAU)
}

/// An orthonormal frame with `normal` as its third column.
pub fn frame_around(normal: Vec3) -> Mat3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Mat3::from_cols(tangent, bitangent, normal)
}

/// An orthonormal frame with `normal` as its third column and the first as close to `tangent` as possible. The second is mirrored if
/// `handedness` is negative.
pub fn frame_along(normal: Vec3, tangent: Vec3, handedness: f32) -> Mat3 {
    let t = (tangent - normal * normal.dot(tangent)).try_normalize();
    let t = t.unwrap_or_else(|| normal.any_orthonormal_vector());
    Mat3::from_cols(t, normal.cross(t) * handedness.signum(), normal)
}

/// The `i`-th of `n` directions of equal solid angle over the hemisphere around +Z. `turn` rotates the set around the axis by a
/// share of a turn, and `shift`, 0 to 1, is the place of the direction in its stratum along the axis.
pub fn lattice_direction(i: usize, n: usize, turn: f32, shift: f32) -> Vec3 {
    let z = (i as f32 + shift) / n as f32;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * ((i as f32 * GOLDEN_TURN).fract() + turn)).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

/// A uniformly distributed direction from two numbers in [0, 1).
pub fn uniform_direction(u: f32, v: f32) -> Vec3 {
    let y = 1.0 - 2.0 * u;
    let r = (1.0 - y * y).max(0.0).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    Vec3::new(r * sin, y, r * cos)
}

/// A cosine-distributed direction around +Z from two numbers in [0, 1); its pdf is `z / π`.
pub fn cosine_direction(u: f32, v: f32) -> Vec3 {
    let r = u.sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    Vec3::new(r * cos, r * sin, (1.0 - u).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibonacci_points_are_unit_balanced_and_spread() {
        let points = fibonacci_directions(4096);
        assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-5));
        let mean: Vec3 = points.iter().sum::<Vec3>() / 4096.0;
        assert!(mean.length() < 1e-3);
        // The integral of y² over the sphere is 4π/3: a clumped set would miss it.
        let second: f32 = points.iter().map(|p| p.y * p.y).sum::<f32>() / 4096.0;
        assert!((second - 1.0 / 3.0).abs() < 1e-4);
    }

    #[test]
    fn cosine_directions_have_mean_height_two_thirds() {
        let n = 64;
        let heights = (0..n * n).map(|i| {
            let (u, v) = ((i / n) as f32 + 0.5, (i % n) as f32 + 0.5);
            cosine_direction(u / n as f32, v / n as f32).z
        });
        assert!((heights.sum::<f32>() / (n * n) as f32 - 2.0 / 3.0).abs() < 1e-3);
    }
}
