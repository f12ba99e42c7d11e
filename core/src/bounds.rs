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

    /// Center of the box.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }
}
