//! A GGX lobe (Walter et al. 2007; Heitz 2014) without its Fresnel factor.
//!
//! Shadowing and masking are Smith's, correlated by height. The filtered lobe follows Tokuyoshi et al. 2024 (*Hierarchical
//! Light Sampling with Accurate Spherical Gaussian Lighting*): in projected slope space the widths of lobe and light add
//! up.

use super::{
    LightsX8,
    microfacet::{HalfVectorLobe, HalfVectors, Sym2x8, slopes},
};
use crate::simd::{Lanes, Vec3x8};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Widths along the tangent and the bitangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxLobe {
    alpha: [f32; 2],
    /// `alpha² / (1 - alpha²)`: the lobe's width in projected slope space.
    slope: [f32; 2],
}

impl GgxLobe {
    /// A lobe of widths up to 1.
    #[inline]
    pub fn new(alpha: [f32; 2]) -> Self {
        Self { alpha, slope: slopes(alpha) }
    }

    /// The widths.
    #[inline]
    pub fn alpha(&self) -> [f32; 2] {
        self.alpha
    }

    /// `D G / (4 |n·wi| |n·wo|)` times the cosine; zero for lights below the horizon.
    ///
    /// With `A` the filtered widths in projected slope space, the squared widths are `M = (A + det A) / (1 + tr A + det A)`, and
    /// `det M = det A / (1 + tr A + det A)`. D and G share one division.
    #[inline(always)]
    pub fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, half: &HalfVectors<L>, wo: Vec3) -> L {
        let LightsX8 { wi, above, .. } = *lights;
        let spread = half.spread(wi, wo, &lights.spread);
        let a = Sym2x8 { xx: L::splat(self.slope[0]) + spread.xx, yy: L::splat(self.slope[1]) + spread.yy, ..spread };
        let det_a = a.determinant();
        let scale = L::splat(1.0) / (L::splat(1.0) + a.xx + a.yy + det_a);
        let m = Sym2x8 { xx: (a.xx + det_a) * scale, xy: a.xy * scale, yy: (a.yy + det_a) * scale };
        let determinant = (det_a * scale).at_least(1e-14);
        // The squared distance of the half vector from the normal in widths, times the determinant.
        let distance = half.adjugate_quadratic(&m) + determinant * half.cos_sq();
        let (cos_i, cos_o) = (wi.z.at_least(0.0), L::splat(wo.z.max(1e-4)));
        let (ox, oy) = (L::splat(wo.x), L::splat(wo.y));
        // Smith's G / (4 n·wi n·wo), times n·wi, has both square roots of Heitz 2014, Eq. 99.
        let root_o = (cos_o * cos_o + m.quadratic(ox, oy)).sqrt();
        let root_i = (cos_i * cos_i + m.quadratic(wi.x, wi.y)).sqrt();
        let shadowing = (cos_i * root_o + cos_o * root_i).at_least(1e-9);
        let numerator = L::splat(0.5 * FRAC_1_PI) * determinant * determinant.sqrt() * cos_i;
        numerator / (distance * distance * shadowing) * above
    }

    /// A visible normal (Heitz 2018, *Sampling the GGX Distribution of Visible Normals*).
    pub fn sample_half_vector(&self, wo: Vec3, u: f32, v: f32) -> Vec3 {
        let (sin, cos) = (TAU * v).sin_cos();
        self.visible_normal(wo, u.sqrt() * Vec2::new(cos, sin))
    }

    /// The visible normal for a point of the unit disc. Uniform points give normals distributed as the lobe.
    pub fn visible_normal(&self, wo: Vec3, disc: Vec2) -> Vec3 {
        let [ax, ay] = self.alpha;
        let stretched = Vec3::new(ax * wo.x, ay * wo.y, wo.z).normalize();
        // The pair needs a level t1, so that the half disc is the lower one.
        let (t1, t2) = if stretched.z < 0.9999 {
            let level = Vec3::Z.cross(stretched).normalize();
            (level, stretched.cross(level))
        } else {
            stretched.any_orthonormal_pair()
        };
        let s = 0.5 * (1.0 + stretched.z);
        let p1 = disc.x;
        let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * disc.y;
        let n = t1 * p1 + t2 * p2 + stretched * (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        Vec3::new(ax * n.x, ay * n.y, n.z.max(1e-6)).normalize()
    }

    /// `D(h) G1(wo) / (4 n·wo)`: density of the light direction when half vectors are visible normals.
    pub fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let h = (wi + wo).normalize_or(Vec3::Z);
        if !(h.z > 0.0) {
            return 0.0;
        }
        let [ax2, ay2] = self.alpha.map(|alpha| alpha * alpha);
        let e = h.x * h.x / ax2 + h.y * h.y / ay2 + h.z * h.z;
        let d = FRAC_1_PI / (self.alpha[0] * self.alpha[1] * e * e);
        d / (2.0 * (wo.z + self.root(wo)))
    }

    /// [`Self::pdf`] of eight light directions.
    #[inline(always)]
    pub fn pdf_x8<L: Lanes>(&self, wi: Vec3x8<L>, wo: Vec3) -> L {
        let sum = wi + Vec3x8::splat(wo);
        let [ax2, ay2] = self.alpha.map(|alpha| alpha * alpha);
        let length_sq = sum.dot(sum);
        let e = sum.x * sum.x * L::splat(1.0 / ax2) + sum.y * sum.y * L::splat(1.0 / ay2) + sum.z * sum.z;
        let ratio = length_sq / e;
        let scale = FRAC_1_PI / (self.alpha[0] * self.alpha[1] * 2.0 * (wo.z + self.root(wo)));
        (ratio * ratio * L::splat(scale)) & sum.z.simd_gt(L::splat(0.0))
    }

    /// The lobe times the cosine over the density of a sampled direction. Its mean is the albedo.
    pub fn weight(&self, wi: Vec3, wo: Vec3) -> f32 {
        if !(wi.z > 0.0) {
            return 0.0;
        }
        let (root_i, root_o) = (self.root(wi), self.root(wo));
        wi.z * (wo.z + root_o) / (wi.z * root_o + wo.z * root_i)
    }

    /// `cos (1 + 2 Λ)` of a direction.
    fn root(&self, w: Vec3) -> f32 {
        let [ax2, ay2] = self.alpha.map(|alpha| alpha * alpha);
        (w.z * w.z + ax2 * w.x * w.x + ay2 * w.y * w.y).sqrt()
    }
}

impl HalfVectorLobe for GgxLobe {
    fn half_vector(&self, wo: Vec3, u: f32, v: f32) -> Vec3 {
        self.sample_half_vector(wo, u, v)
    }

    fn density(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.pdf(wi, wo)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::uniform_direction;
    use wide::f32x8;

    #[test]
    fn densities_of_eight_directions_are_those_of_each() {
        let (lobe, wo) = (GgxLobe::new([0.1, 0.4]), Vec3::new(0.3, -0.2, 0.8).normalize());
        for i in 0..200 {
            let wi: [Vec3; 8] = std::array::from_fn(|lane| {
                let at = (8 * i + lane) as f32;
                uniform_direction((at * 0.618_034).fract(), (at + 0.5) / 1600.0)
            });
            let found = lobe.pdf_x8::<f32x8>(Vec3x8::from_array(wi), wo).to_array();
            for (found, wi) in found.into_iter().zip(wi) {
                let expected = lobe.pdf(wi, wo);
                assert!((found - expected).abs() <= 1e-4 * expected.max(1e-3), "{found} for {expected} at {wi}");
            }
        }
        let other = GgxLobe::new([0.1, 0.39]).pdf_x8::<f32x8>(Vec3x8::splat(Vec3::Z), wo).to_array()[0];
        assert!((other / lobe.pdf(Vec3::Z, wo) - 1.0).abs() > 1e-3, "negative control: another lobe");
    }
}
