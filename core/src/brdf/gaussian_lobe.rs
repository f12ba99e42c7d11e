//! A lobe with normally distributed slopes of half vectors, as Beckmann and Ward use it.

use super::{
    LightsX8,
    microfacet::{HalfVectorLobe, HalfVectors, Sym2x8},
};
use crate::simd::Lanes;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use wide::f32x8;

/// Widths along the tangent and the bitangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianLobe {
    alpha: [f32; 2],
}

/// The lobe filtered by the spread of eight lights.
pub struct FilteredX8<L> {
    /// Squared widths, a matrix.
    pub alpha_sq: Sym2x8<L>,
    /// `exp(-tan²) / (π αx αy)`: the density of half vectors times the fourth power of their cosines.
    pub density: L,
    /// Squared cosines of the half vectors.
    pub cos_h_sq: L,
}

impl GaussianLobe {
    /// A lobe of these widths.
    pub fn new(alpha: [f32; 2]) -> Self {
        Self { alpha }
    }

    /// The widths.
    pub fn alpha(&self) -> [f32; 2] {
        self.alpha
    }

    /// Widens the lobe by the spread of the lights: in the space of half vectors variances add up.
    #[inline(always)]
    pub fn filtered<L: Lanes>(&self, half: &HalfVectors<L>, lights: &LightsX8<L>, wo: Vec3) -> FilteredX8<L> {
        let spread = half.spread(lights.wi, wo, &lights.spread);
        let [x, y] = self.alpha;
        let [xx, yy] = [L::splat(x * x), L::splat(y * y)];
        let m = Sym2x8 { xx: spread.xx + xx, xy: spread.xy, yy: spread.yy + yy };
        let determinant = m.determinant().at_least(1e-14);
        let cos_h_sq = half.cos_sq().at_least(1e-4);
        let exponent = half.adjugate_quadratic(&m) / (determinant * cos_h_sq);
        let density = (-exponent).exp() * L::splat(FRAC_1_PI) / determinant.sqrt();
        FilteredX8 { alpha_sq: m, density, cos_h_sq }
    }

    /// A half vector, with the density `D cos θh`.
    pub fn sample_half_vector(&self, u: f32, v: f32) -> Vec3 {
        let (sin, cos) = (TAU * v).sin_cos();
        let slope = (-(1.0 - u).max(1e-12).ln()).sqrt();
        Vec3::new(self.alpha[0] * slope * cos, self.alpha[1] * slope * sin, 1.0).normalize()
    }

    /// Density of the light direction for a sampled half vector.
    pub fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let h = (wi + wo).normalize_or(Vec3::Z);
        // Flip a half vector that faces away from `wo`: the sum of both directions points downward.
        let h = if h.z < 0.0 { -h } else { h };
        if !(h.z > 1e-4) {
            return 0.0;
        }
        let [ax, ay] = self.alpha;
        let slope_sq = ((h.x / ax).powi(2) + (h.y / ay).powi(2)) / (h.z * h.z);
        (-slope_sq).exp() / (PI * ax * ay * h.z.powi(3)) / (4.0 * wi.dot(h).abs().max(1e-4))
    }
}

impl HalfVectorLobe for GaussianLobe {
    fn half_vector(&self, _wo: Vec3, u: f32, v: f32) -> Vec3 {
        self.sample_half_vector(u, v)
    }

    fn density(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.pdf(wi, wo)
    }
}

/// Beckmann's lobe times the cosine over the density of a half vector, for an isotropic width.
pub fn beckmann_weight(alpha: f32, wi: Vec3, wo: Vec3, h: Vec3) -> f32 {
    let sq = f32x8::splat(alpha * alpha);
    let alpha_sq = Sym2x8 { xx: sq, xy: f32x8::ZERO, yy: sq };
    let of = |w: Vec3| shadowing(&alpha_sq, f32x8::splat(w.x), f32x8::splat(w.y), f32x8::splat(w.z)).to_array()[0];
    of(wi) * of(wo) * wi.dot(h) / (wo.z * h.z)
}

/// Ward's lobe of 1992 times the cosine over the density of a half vector, for a reflectance of 1.
pub fn ward_weight(wi: Vec3, wo: Vec3, h: Vec3) -> f32 {
    (wi.z / wo.z).sqrt() * h.z.powi(3) * wi.dot(h)
}

/// Shadowing of one direction, for Beckmann's lobe.
#[inline(always)]
pub fn shadowing<L: Lanes>(alpha_sq: &Sym2x8<L>, x: L, y: L, cosine: L) -> L {
    // Cosine over width times sine; ratios above 1.6 are not shadowed.
    let ratio = cosine / alpha_sq.quadratic(x, y).at_least(1e-12).sqrt();
    let above = ratio * (L::splat(3.535) + L::splat(2.181) * ratio);
    let below = L::splat(1.0) + ratio * (L::splat(2.276) + L::splat(2.577) * ratio);
    ratio.simd_lt(L::splat(1.6)).select(above / below, L::splat(1.0))
}
