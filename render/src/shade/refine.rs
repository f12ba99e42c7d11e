//! BRDF refinement: which nodes of the merged cut are too wide for the BRDF, during the traversal.
//!
//! The paper samples the BRDF once per merged node and names this its weak point (section 6). In dyadic form the merge
//! can go down where this pixel's lobe looks: from nodes of lit cuts into the stored ones below them, and on into the light
//! tree, which holds the means of all halves. That is an implicit BRDF cut, merged with the others.

use super::node_field::EightCones;
use glam::Vec3;
use lapidary_core::{
    brdf::{Lobes, narrow_widths},
    simd::{Lanes, Vec3x8},
};

/// Narrowest lobe that refinement follows. For narrower ones the light samples themselves are too coarse, and the
/// filtered lobe is used.
const NARROWEST: f32 = 0.01;
/// A node is fine enough when its radius is below this many lobe widths.
const FINE: f32 = 0.7;
/// A node is fine enough when its light reflects less than this share of what the lobe reflects of even light of the
/// tree's mean.
const NEGLIGIBLE: f32 = 0.02;

/// Radius in radians above which a node is too wide for one direction, whatever the lobe: colors of its light that come from
/// different sides would be mixed.
const WIDEST: f32 = 0.35;

/// The shader's copies of these are compared with them in a test.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 4] =
    [("NARROWEST", NARROWEST), ("FINE", FINE), ("NEGLIGIBLE", NEGLIGIBLE), ("WIDEST", WIDEST)];

/// Whether eight cones are too wide for one cosine to `normal`, as a mask. They are not if they are below the horizon.
#[inline(always)]
pub fn are_too_wide_for_a_cosine<L: Lanes>(cones: &EightCones<L>, normal: Vec3) -> L {
    let cosine = cones.direction.dot(Vec3x8::splat(normal));
    cones.radius.simd_gt(L::splat(WIDEST)) & cosine.simd_gt(-cones.radius)
}

/// The criterion for one pixel.
pub struct Refinement {
    /// Their narrower widths, at least [`NARROWEST`]; the first `count`.
    lobes: [f32; 3],
    count: usize,
}

impl Refinement {
    /// For the lobes that are there.
    pub fn new(lobes: Lobes) -> Self {
        let (mut refinement, widths) = (Self { lobes: [0.0; 3], count: 0 }, narrow_widths(lobes));
        for width in widths.into_iter().filter(|&width| width > 0.0) {
            refinement.lobes[refinement.count] = width.max(NARROWEST);
            refinement.count += 1;
        }
        refinement
    }

    /// Whether eight cones at an angle of these cosines to the lobes' peak are too wide for their light to have one direction,
    /// as a mask: what some lobe, widened by the node, reflects of it is not negligible.
    #[inline(always)]
    pub fn are_too_wide<L: Lanes>(&self, cones: &EightCones<L>, cos: L) -> L {
        let mut any = L::splat(0.0);
        for &lobe in &self.lobes[..self.count] {
            any = any | are_too_wide_for(lobe, cones, cos);
        }
        any
    }
}

/// Whether cones are too wide for a lobe that has its peak at an angle of these cosines.
#[inline(always)]
fn are_too_wide_for<L: Lanes>(lobe: f32, cones: &EightCones<L>, cos: L) -> L {
    let &EightCones { radius, brightness, .. } = cones;
    // In the space of half vectors distances are half as large: the node is a disc of radius r / 2, whose variance along
    // an axis widens the lobe.
    let node_sq = L::splat(0.25) * radius * radius;
    let width_sq = L::splat(lobe * lobe) + L::splat(0.25) * node_sq;
    // The squared tangent of half of the angle to the peak is (1 - cos) / (1 + cos).
    let near = L::splat(1.0) + cos;
    let far = width_sq * near + (L::splat(1.0) - cos);
    let shows = (brightness * node_sq * width_sq * near * near).simd_gt(L::splat(NEGLIGIBLE) * far * far);
    radius.simd_gt(L::splat(FINE * lobe)) & shows
}
