//! BRDF refinement: the traversal finds nodes of the merged cut that are too wide for the BRDF.
//!
//! The paper samples the BRDF once per merged node and calls this its weak point (section 6). In a binary tree the merge can
//! descend within the pixel's lobe: from nodes of lit cuts into the stored nodes below, and on into the light tree, which holds the
//! means of all halves. This is an implicit BRDF cut, merged with the others.

use super::node_field::EightCones;
use glam::Vec3;
use lapidary_core::{
    brdf::{Lobes, narrow_widths},
    simd::{Lanes, Vec3x8},
};

/// Narrowest lobe for refinement. For narrower lobes the light samples are too coarse, and the filtered lobe is used.
const NARROWEST: f32 = 0.01;
/// A node is fine enough when its radius is below this many lobe widths.
const FINE: f32 = 0.7;
/// A node is fine enough when its reflected light is below this share of the lobe's reflection of uniform light with the tree's
/// mean.
const NEGLIGIBLE: f32 = 0.02;

/// Radius in radians above which a node is too wide for one direction with any lobe: light of different colors from different sides
/// would mix.
const WIDEST: f32 = 0.35;

/// A test compares the shader's copies with these.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 4] =
    [("NARROWEST", NARROWEST), ("FINE", FINE), ("NEGLIGIBLE", NEGLIGIBLE), ("WIDEST", WIDEST)];

/// Mask of the cones that are too wide for one cosine to `normal`. Cones below the horizon are not.
#[inline(always)]
pub fn are_too_wide_for_a_cosine<L: Lanes>(cones: &EightCones<L>, normal: Vec3) -> L {
    let cosine = cones.direction.dot(Vec3x8::splat(normal));
    cones.radius.simd_gt(L::splat(WIDEST)) & cosine.simd_gt(-cones.radius)
}

/// The refinement criterion for one pixel.
pub struct Refinement {
    /// Narrower widths of the lobes, at least [`NARROWEST`]; the first `count`.
    lobes: [f32; 3],
    count: usize,
}

impl Refinement {
    /// Creates the criterion for the existing lobes.
    pub fn new(lobes: Lobes) -> Self {
        let (mut refinement, widths) = (Self { lobes: [0.0; 3], count: 0 }, narrow_widths(lobes));
        for width in widths.into_iter().filter(|&width| width > 0.0) {
            refinement.lobes[refinement.count] = width.max(NARROWEST);
            refinement.count += 1;
        }
        refinement
    }

    /// Mask of the cones that are too wide for one direction, from the cosines of their angles to the lobes' peak. A cone is too
    /// wide if some lobe, widened by the node, reflects a significant share of its light.
    #[inline(always)]
    pub fn are_too_wide<L: Lanes>(&self, cones: &EightCones<L>, cos: L) -> L {
        let mut any = L::splat(0.0);
        for &lobe in &self.lobes[..self.count] {
            any = any | are_too_wide_for(lobe, cones, cos);
        }
        any
    }
}

/// Mask of the cones that are too wide for one lobe, from the cosines of their angles to its peak.
#[inline(always)]
fn are_too_wide_for<L: Lanes>(lobe: f32, cones: &EightCones<L>, cos: L) -> L {
    let &EightCones { radius, brightness, .. } = cones;
    // Distances halve in the space of half vectors: the node is a disc of radius r / 2, whose variance along an axis widens the
    // lobe.
    let node_sq = L::splat(0.25) * radius * radius;
    let width_sq = L::splat(lobe * lobe) + L::splat(0.25) * node_sq;
    // The squared tangent of half the angle to the peak is (1 - cos) / (1 + cos).
    let near = L::splat(1.0) + cos;
    let far = width_sq * near + (L::splat(1.0) - cos);
    let shows = (brightness * node_sq * width_sq * near * near).simd_gt(L::splat(NEGLIGIBLE) * far * far);
    radius.simd_gt(L::splat(FINE * lobe)) & shows
}
