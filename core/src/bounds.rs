//! Axis-aligned boxes, and the range of coordinates.

use glam::Vec3;

/// The largest coordinate in a scene, in meters. The fourth power of a distance must stay far below the largest `f32`.
pub const MOST_COORDINATE: f32 = 1e9;

/// Whether a place is finite and within [`MOST_COORDINATE`] along every axis.
pub fn is_within_reach(place: Vec3) -> bool {
    place.abs().cmple(Vec3::splat(MOST_COORDINATE)).all()
}

/// Axis-aligned bounds in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The smallest box around `points`; empty bounds (`min > max`) for no points.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        let empty = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
        points.into_iter().fold(empty, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Length of the diagonal in meters; zero for empty bounds.
    pub fn diagonal(&self) -> f32 {
        (self.max - self.min).max(Vec3::ZERO).length()
    }

    /// The box extended on each side, in meters.
    pub fn grown(&self, by: f32) -> Self {
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether a point lies in the box or on its surface.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Whether a ray passes the box within some distance in units of the direction's length. Rays along a face count.
    pub fn meets_ray(&self, origin: Vec3, direction: Vec3, within: f32) -> bool {
        let (mut enters, mut leaves) = (0.0_f32, within);
        for axis in 0..3 {
            let inverse = 1.0 / direction[axis];
            let (a, b) = ((self.min[axis] - origin[axis]) * inverse, (self.max[axis] - origin[axis]) * inverse);
            // Zero times infinity: the ray lies in the plane of a face. `min` and `max` drop NaN.
            enters = enters.max(if a.is_nan() || b.is_nan() { enters } else { a.min(b) });
            leaves = leaves.min(if a.is_nan() || b.is_nan() { leaves } else { a.max(b) });
        }
        enters <= leaves
    }

    /// Center of the box.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }
}
