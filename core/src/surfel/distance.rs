//! Distances of surface points by position and normal (meshless basis paper, Eq. 10 and 11).

use crate::surfel::Surfel;
use glam::Vec3;

/// `F_squash`: surfaces of equal distance are ellipsoids, thinner along the normal by one plus this factor.
pub const SQUASH: f32 = 2.0;
/// A function has little weight where the surface steps to another layer by more than the radius divided by this.
/// Otherwise functions of one of two layers, such as a wall and the wall behind it, take the light of both.
pub const LAYERS: f32 = 8.0;
/// Smallest factor for another layer. It matters only where no function of that layer is close.
pub const LEAST_WEIGHT: f32 = 0.02;

/// Distance in meters of `x` from a point with a unit normal (Eq. 10). Offsets from its tangent plane count more.
#[inline(always)]
pub fn squashed_distance(center: Vec3, normal: Vec3, x: Vec3) -> f32 {
    let v = x - center;
    (v + normal * (SQUASH * v.dot(normal))).length()
}

/// Falls from 1 at the center to 0 at distance 1 and beyond, with zero slope at both (meshless paper, Eq. 9).
#[inline(always)]
pub(crate) fn kernel(t: f32) -> f32 {
    let t = t.min(1.0);
    (2.0 * t - 3.0) * t * t + 1.0
}

/// Factor of weights for a step between layers. `radius` is the unit, `offset` leads from one point to the other, and
/// `normals` is the sum of their unit normals. The offset is at right angles to that sum within a plane, and also on a
/// sphere or cylinder, however much it leaves the plane.
#[inline(always)]
pub(crate) fn same_layer(offset: Vec3, normals: Vec3, radius: f32) -> f32 {
    let step = 0.5 * offset.dot(normals).abs() / radius;
    LEAST_WEIGHT + (1.0 - LEAST_WEIGHT) * kernel(LAYERS * step)
}

/// Factor of two unit normals in weights and distances: their squared cosine, zero where they face apart.
#[inline(always)]
pub fn alignment(a: Vec3, b: Vec3) -> f32 {
    let cosine = a.dot(b).max(0.0);
    cosine * cosine
}

/// Distance in meters of two surface points in position and normal (Eq. 11). It is infinite if the normals are at right
/// angles or more, and never less than the distance of the positions.
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
        Surfel { position, normal, ..Default::default() }
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
    fn layers_are_told_from_curves() {
        let bent = |angle: f32| Vec3::new(angle.sin(), angle.cos(), 0.0);
        let on_curve = same_layer(bent(0.7) - bent(-0.2), bent(0.7) + bent(-0.2), 2.0);
        let in_plane = same_layer(Vec3::X, 2.0 * Vec3::Y, 2.0);
        assert!([on_curve, in_plane].iter().all(|f| (f - 1.0).abs() < 1e-5), "{on_curve}, {in_plane}");
        let behind = |gap: f32| same_layer(Vec3::X - gap * Vec3::Y, 2.0 * Vec3::Y, 2.0);
        assert!(behind(0.25) == LEAST_WEIGHT && behind(9.0) == LEAST_WEIGHT);
        assert!((behind(0.125) - 0.51).abs() < 1e-6, "halfway: half of the kernel's range from 0.02 to 1");
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
