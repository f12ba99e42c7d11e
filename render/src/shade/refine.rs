//! BRDF refinement: which nodes of the merged cut are too wide for the BRDF, during the traversal.
//!
//! The paper samples the BRDF once per merged node and names this its weak point (section 6). In dyadic form the merge
//! can go down where this pixel's lobe looks: from nodes of lit cuts into the stored ones below them, and on into the light
//! tree, which holds the means of all halves. That is an implicit BRDF cut, merged with the others.

use glam::Vec3;
use lapidary_core::brdf::{Lobes, narrow_widths};

/// Narrowest lobe that refinement follows. For narrower ones the light samples themselves are too coarse, and the
/// filtered lobe is used.
const NARROWEST: f32 = 0.01;
/// A node is fine enough when its radius is below this many lobe widths.
const FINE: f32 = 0.7;
/// A node is fine enough when its light reflects less than this share of what the lobe reflects of even light of the
/// tree's mean.
const NEGLIGIBLE: f32 = 0.02;

/// Radius in radians above which a node is too wide for one direction, whatever the lobe: colours of its light that come from
/// different sides would be mixed.
const WIDEST: f32 = 0.35;

/// The shader's copies of these are compared with them in a test.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 4] =
    [("NARROWEST", NARROWEST), ("FINE", FINE), ("NEGLIGIBLE", NEGLIGIBLE), ("WIDEST", WIDEST)];

/// Whether the cone of `radius` around the local direction `wi` is too wide for one cosine. It is not if it is below the
/// horizon.
#[inline(always)]
pub fn is_too_wide_for_a_cosine(wi: Vec3, radius: f32) -> bool {
    radius > WIDEST && wi.z > -radius
}

/// The criterion for one pixel.
pub struct Refinement {
    /// Their narrower widths, at least [`NARROWEST`]; 0 for none.
    lobes: [f32; 3],
    /// Direction of the lobe's peak, mirrored at the normal.
    mirrored: Vec3,
}

impl Refinement {
    /// For lobes seen from the local direction `wo`.
    pub fn new(lobes: Lobes, wo: Vec3) -> Self {
        let lobes = narrow_widths(lobes).map(|width| if width > 0.0 { width.max(NARROWEST) } else { 0.0 });
        Self { lobes, mirrored: Vec3::new(-wo.x, -wo.y, wo.z) }
    }

    /// Whether the cone of `radius` around the local direction `wi` is too wide for its light, of this `brightness`, to have
    /// one direction: what some lobe, widened by the node, reflects of it is not negligible.
    #[inline(always)]
    pub fn is_too_wide(&self, wi: Vec3, radius: f32, brightness: f32) -> bool {
        // The squared tangent of half of the angle to the peak is (1 - cos) / (1 + cos).
        let cos = wi.dot(self.mirrored);
        self.lobes.iter().any(|&lobe| lobe > 0.0 && is_too_wide_for(lobe, cos, radius, brightness))
    }
}

/// Whether a cone is too wide for a lobe that has its peak at an angle of this cosine.
#[inline(always)]
fn is_too_wide_for(lobe: f32, cos: f32, radius: f32, brightness: f32) -> bool {
    if radius <= FINE * lobe {
        return false;
    }
    // In the space of half vectors distances are half as large: the node is a disc of radius r / 2, whose variance along
    // an axis widens the lobe.
    let node_sq = 0.25 * radius * radius;
    let width_sq = lobe * lobe + 0.25 * node_sq;
    let (near, far) = (1.0 + cos, width_sq * (1.0 + cos) + (1.0 - cos));
    brightness * node_sq * width_sq * near * near > NEGLIGIBLE * far * far
}
