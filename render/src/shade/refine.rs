//! BRDF refinement: which nodes of the merged cut are too wide for the BRDF, during the traversal.
//!
//! The paper samples the BRDF once per merged node and names this its weak point (section 6). In dyadic form the merge
//! can go down where this pixel's lobe looks: from nodes of lit cuts into the stored ones below them, and on into the light
//! tree, which holds the means of all halves. That is an implicit BRDF cut, merged with the others.

use glam::Vec3;
use lapidary_core::brdf::LobeWidth;

/// Narrowest lobe that refinement follows. For narrower ones the light samples themselves are too coarse, and the
/// filtered lobe is used.
const NARROWEST: f32 = 0.01;
/// A node is fine enough when its radius is below this many lobe widths.
const FINE: f32 = 0.7;
/// A node whose light has less weight than this in the peak-normalised lobe is fine enough. Light of the tree's mean
/// counts once, brighter light in proportion.
const NEGLIGIBLE: f32 = 0.02;

/// The shader's copies of these are compared with them in a test.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 3] = [("NARROWEST", NARROWEST), ("FINE", FINE), ("NEGLIGIBLE", NEGLIGIBLE)];

/// The criterion for one pixel.
pub struct Refinement {
    lobe: f32,
    /// Direction of the lobe's peak, mirrored at the normal.
    mirrored: Vec3,
}

impl Refinement {
    /// For a lobe seen from the local direction `wo`.
    pub fn new(lobe: LobeWidth, wo: Vec3) -> Self {
        Self { lobe: lobe.narrow().max(NARROWEST), mirrored: Vec3::new(-wo.x, -wo.y, wo.z) }
    }

    /// Whether the cone of `radius` around the local direction `wi` is too wide for its light, of this `brightness`, to have
    /// one direction.
    #[inline(always)]
    pub fn is_too_wide(&self, wi: Vec3, radius: f32, tan_half_radius: f32, brightness: f32) -> bool {
        let lobe = self.lobe;
        if radius <= FINE * lobe {
            return false;
        }
        // Half of the angle to the mirrored direction: no half vector is nearer to the normal. Minus half of the node's
        // radius it is the best within the node.
        let cos = wi.dot(self.mirrored);
        let tan_half = ((1.0 - cos).max(0.0) / (1.0 + cos).max(1e-6)).sqrt();
        let tan = ((tan_half - tan_half_radius) / (1.0 + tan_half * tan_half_radius)).max(0.0);
        let fall_off = 1.0 + tan * tan / (lobe * lobe);
        (radius / lobe).min(4.0) * brightness > NEGLIGIBLE * fall_off * fall_off
    }
}
