//! A triangle as seen from one origin: the edge planes through the origin decide which directions cross it.
//!
//! All rays of a batch share their origin, so the three edge planes are computed once per triangle and a
//! direction costs three dot products. Neighboring triangles compute the plane of their common edge from
//! the same operands with opposite sign, which IEEE arithmetic negates exactly: no ray slips through between.
//! No fused multiply-add is used anywhere: all instruction sets give the same bits.

use super::Hit;
use glam::{Vec2, Vec3};

/// A triangle relative to a ray origin.
#[derive(Clone, Copy)]
pub(super) struct TriangleFrom {
    /// Normals of the planes through the origin and each edge, pointing inward; `edges[i]` is opposite corner `i`.
    pub edges: [Vec3; 3],
    /// Face normal (not unit) and the first corner, relative to the origin.
    pub normal: Vec3,
    corner: Vec3,
    /// Twice the signed distance to the triangle's plane times its area; positive if the back is seen.
    pub side: f32,
}

impl TriangleFrom {
    #[inline(always)]
    pub fn new(origin: Vec3, corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|p| p - origin);
        // From the edges and not as a · (b × c): this stays accurate far from the origin.
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let side = a.dot(normal);
        let sign = if side < 0.0 { -1.0 } else { 1.0 };
        Self { edges: [b.cross(c) * sign, c.cross(a) * sign, a.cross(b) * sign], normal, corner: a, side }
    }

    /// The triangle, if a ray along `direction` may hit it. The signs of two edge planes reject most misses before
    /// anything else is computed.
    #[inline(always)]
    pub fn unless_missed(origin: Vec3, corners: [Vec3; 3], direction: Vec3) -> Option<Self> {
        let [a, b, c] = corners.map(|p| p - origin);
        // All planes point inward or all outward; multiplying by -1 does not round.
        let (u, v) = (dot(b.cross(c), direction), dot(c.cross(a), direction));
        if (u > 0.0 && v < 0.0) || (u < 0.0 && v > 0.0) {
            return None;
        }
        let w = dot(a.cross(b), direction);
        if (w > 0.0 && (u < 0.0 || v < 0.0)) || (w < 0.0 && (u > 0.0 || v > 0.0)) {
            return None;
        }
        Some(Self::new(origin, corners))
    }

    /// Whether the ray along `direction` hits the triangle. A ray from the triangle's plane never does.
    #[inline(always)]
    pub fn crosses(&self, direction: Vec3) -> bool {
        self.side != 0.0 && self.edges.iter().all(|&e| dot(e, direction) >= 0.0)
    }

    /// Whether the segment from the origin by `segment` crosses the triangle, with its end beyond the triangle's plane.
    #[inline(always)]
    pub fn crosses_before(&self, segment: Vec3) -> bool {
        let sign = if self.side < 0.0 { -1.0 } else { 1.0 };
        dot(self.normal * sign, segment) > self.side.abs() && self.crosses(segment)
    }

    /// Signed distance of the triangle's plane from the origin, times the length of the normal.
    #[inline(always)]
    pub fn plane_distance(&self) -> f32 {
        self.corner.dot(self.normal)
    }

    /// Distance and barycentric weights of the hit, if any; the triangle index is left at 0.
    #[inline]
    pub fn hit(&self, direction: Vec3) -> Option<Hit> {
        if !self.crosses(direction) {
            return None;
        }
        let weights = Vec3::from_array(self.edges.map(|e| dot(e, direction)));
        let sum = weights.element_sum();
        let distance = self.plane_distance() / direction.dot(self.normal);
        (sum > 0.0 && distance > 0.0).then(|| Hit {
            triangle: 0,
            distance,
            barycentric: Vec2::new(weights.y, weights.z) / sum,
            back_face: self.side > 0.0,
        })
    }
}

/// The dot product in the batch's order of operations.
#[inline(always)]
pub(super) fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
