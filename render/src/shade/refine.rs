//! BRDF refinement: halves nodes of the merged cut that are too wide for the BRDF, during the traversal.
//!
//! The paper samples the BRDF once per merged node and names this its weak point (section 6). In dyadic form a node can
//! be halved on the fly, because the light tree holds the means of its halves: an implicit BRDF cut, merged with the
//! others.

use glam::Vec3;
use lapidary_core::brdf::LobeWidth;

/// Narrowest lobe that refinement follows. For narrower ones the light samples themselves are too coarse, and the
/// filtered lobe is used.
const NARROWEST: f32 = 0.01;
/// A node is fine enough when its radius is below this many lobe widths.
const FINE: f32 = 0.7;
/// A node with less weight than this in the peak-normalised lobe is not worth halving.
const NEGLIGIBLE: f32 = 0.02;
/// Radius in radians above which a node is too wide even for the cosine alone.
const WIDEST: f32 = 0.35;

/// The shader's copies of these are compared with them in a test.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 4] =
    [("NARROWEST", NARROWEST), ("FINE", FINE), ("NEGLIGIBLE", NEGLIGIBLE), ("WIDEST", WIDEST)];

/// The criterion for one pixel.
pub struct Refinement {
    lobe: Option<f32>,
    wo: Vec3,
}

impl Refinement {
    /// For a lobe seen from the local direction `wo`.
    pub fn new(lobe: Option<LobeWidth>, wo: Vec3) -> Self {
        Self { lobe: lobe.map(|l| l.narrow().max(NARROWEST)), wo }
    }

    /// Whether the cone of `radius` around the local direction `wi` is too wide for its light to have one direction.
    #[inline(always)]
    pub fn is_too_wide(&self, wi: Vec3, radius: f32, tan_half_radius: impl FnOnce() -> f32) -> bool {
        if radius > WIDEST {
            return wi.z > -radius;
        }
        let Some(lobe) = self.lobe else { return false };
        if radius <= FINE * lobe {
            return false;
        }
        let half = wi + self.wo;
        // Tangent of the angle between normal and half vector, minus half of the node's radius: the best within the
        // node.
        let tan_h = (half.x * half.x + half.y * half.y).sqrt() / half.z.max(1e-6);
        let tan_r = tan_half_radius();
        let tan = ((tan_h - tan_r) / (1.0 + tan_h * tan_r)).max(0.0);
        let fall_off = 1.0 + tan * tan / (lobe * lobe);
        (radius / lobe).min(4.0) > NEGLIGIBLE * fall_off * fall_off
    }
}
