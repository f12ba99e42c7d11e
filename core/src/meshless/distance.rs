//! Distances of surface points by position and normal (meshless basis paper, Eq. 10 and 11).

use crate::surfel::Surfel;
use glam::Vec3;

/// `F_squash`: surfaces of equal distance are ellipsoids, thinner along the normal by one plus this.
pub const SQUASH: f32 = 2.0;

/// Distance in metres of `x` from a point with a unit normal (Eq. 10): what leaves its tangent plane is farther.
#[inline(always)]
pub fn squashed_distance(center: Vec3, normal: Vec3, x: Vec3) -> f32 {
    let v = x - center;
    (v + normal * (SQUASH * v.dot(normal))).length()
}

/// The factor of two unit normals in weights and distances: the square of their cosine, zero where they face apart.
#[inline(always)]
pub fn alignment(a: Vec3, b: Vec3) -> f32 {
    let cosine = a.dot(b).max(0.0);
    cosine * cosine
}

/// Distance in metres of two surface points in position and normal (Eq. 11). Infinite between points whose normals are at
/// right angles or more, and never less than the distance of their positions.
pub fn distance(p: &Surfel, q: &Surfel) -> f32 {
    let near =
        squashed_distance(p.position, p.normal, q.position).min(squashed_distance(q.position, q.normal, p.position));
    let alignment = alignment(p.normal, q.normal);
    if alignment > 0.0 { near / alignment } else { f32::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surfel(position: Vec3, normal: Vec3) -> Surfel {
        Surfel { position, normal, place: Default::default() }
    }

    #[test]
    fn known_distances() {
        let p = surfel(Vec3::ZERO, Vec3::Y);
        assert_eq!(distance(&p, &surfel(Vec3::X, Vec3::Y)), 1.0, "in the plane");
        assert_eq!(distance(&p, &surfel(Vec3::Y, Vec3::Y)), 3.0, "along the normal");
        let tilted = surfel(Vec3::X, Vec3::new(0.0, 0.6, 0.8));
        assert!((distance(&p, &tilted) - 1.0 / 0.36).abs() < 1e-5, "a tilted normal");
        assert_eq!(distance(&p, &surfel(Vec3::X * 1e-6, Vec3::X)), f32::INFINITY, "at a right angle");
        assert_eq!(distance(&p, &surfel(Vec3::ZERO, Vec3::NEG_Y)), f32::INFINITY, "the other side");
    }

    #[test]
    fn it_is_symmetric_and_bounds_the_distance_of_positions() {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut unit = || Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5);
        for _ in 0..1000 {
            let (p, q) = (surfel(unit(), unit().normalize()), surfel(unit(), unit().normalize()));
            assert_eq!(distance(&p, &q), distance(&q, &p));
            assert!(distance(&p, &q) >= p.position.distance(q.position) * 0.999);
        }
    }
}
