//! A lobe whose half vectors are distributed as a power of their cosine, with two exponents (Ashikhmin and Shirley 2000).

use super::{
    LightsX8,
    microfacet::{HalfVectorLobe, HalfVectors, Sym2x8, slopes},
};
use crate::simd::Lanes;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, TAU};
use wide::f32x8;

/// Widths along the tangent and the bitangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobe {
    /// `2 / n` for the exponents: the width in projected slope space, as for GGX.
    slope: [f32; 2],
    alpha: [f32; 2],
}

/// The lobe filtered by the spread of eight lights.
pub struct FilteredX8<L> {
    /// `cos θh` to the exponent in the direction of the half vector.
    pub power: L,
    /// Squared width in slope space, a matrix.
    slope: Sym2x8<L>,
}

impl<L: Lanes> FilteredX8<L> {
    /// `sqrt((nu + 1) (nv + 1))`.
    #[inline(always)]
    pub fn two_exponents(&self) -> L {
        let (determinant, trace) = (self.slope.determinant().at_least(1e-14), self.slope.xx + self.slope.yy);
        ((determinant + trace + trace + L::splat(4.0)) / determinant).sqrt()
    }

    /// The geometric mean of both exponents.
    #[inline(always)]
    pub fn exponent(&self) -> L {
        L::splat(2.0) / self.slope.determinant().at_least(1e-14).sqrt()
    }
}

/// `ln(1 - s)`: a logarithm near one is too coarse for large exponents.
#[inline(always)]
fn log_of_rest<L: Lanes>(s: L) -> L {
    let series = -s * (L::splat(1.0) + s * (L::splat(0.5) + s * (L::splat(1.0 / 3.0) + s * L::splat(0.25))));
    let exact = (L::splat(1.0) - s).at_least(1e-8).ln();
    s.simd_lt(L::splat(0.03)).select(series, exact)
}

impl PhongLobe {
    /// A lobe with exponents `2 / alpha² - 2`, as wide as microfacets of these widths.
    pub fn new(alpha: [f32; 2]) -> Self {
        Self { slope: slopes(alpha), alpha }
    }

    /// The microfacet widths.
    pub fn alpha(&self) -> [f32; 2] {
        self.alpha
    }

    fn exponents(&self) -> [f32; 2] {
        self.slope.map(|slope| 2.0 / slope)
    }

    /// The geometric mean of both exponents.
    pub fn mean_exponent(&self) -> f32 {
        let [nu, nv] = self.exponents();
        (nu * nv).sqrt()
    }

    /// Widens the lobe by the spread of the lights: in projected slope space variances add up.
    #[inline(always)]
    pub fn filtered<L: Lanes>(&self, half: &HalfVectors<L>, lights: &LightsX8<L>, wo: Vec3) -> FilteredX8<L> {
        let spread = half.spread(lights.wi, wo, &lights.spread);
        let [xx, yy] = [L::splat(self.slope[0]), L::splat(self.slope[1])];
        let slope = Sym2x8 { xx: spread.xx + xx, xy: spread.xy, yy: spread.yy + yy };
        let determinant = slope.determinant().at_least(1e-14);
        let sin_sq = half.sin_sq().at_least(1e-12);
        // Half the exponent, for the logarithm of the squared cosine.
        let exponent = half.adjugate_quadratic(&slope) / (determinant * sin_sq);
        FilteredX8 { power: (exponent * log_of_rest(sin_sq)).exp(), slope }
    }

    /// A half vector (Ashikhmin and Shirley 2000, Eq. 9 and 10).
    pub fn sample_half_vector(&self, u: f32, v: f32) -> Vec3 {
        let [nu, nv] = self.exponents();
        // One quadrant, mirrored into the others.
        let (quadrant, within) = ((4.0 * u).floor(), (4.0 * u).fract());
        let first = (((nu + 1.0) / (nv + 1.0)).sqrt() * (FRAC_PI_2 * within).tan()).atan();
        let angle = match quadrant as u32 {
            0 => first,
            1 => 2.0 * FRAC_PI_2 - first,
            2 => 2.0 * FRAC_PI_2 + first,
            _ => 4.0 * FRAC_PI_2 - first,
        };
        let (sin, cos) = angle.sin_cos();
        let exponent = nu * cos * cos + nv * sin * sin;
        let cos_h = (1.0 - v).max(1e-12).powf(1.0 / (exponent + 1.0));
        let sin_h = (1.0 - cos_h * cos_h).max(0.0).sqrt();
        Vec3::new(sin_h * cos, sin_h * sin, cos_h)
    }

    /// Density of the light direction for a sampled half vector.
    pub fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let h = (wi + wo).normalize_or(Vec3::Z);
        // Flip a half vector that faces away from `wo`: the sum of both directions points downward.
        let h = if h.z < 0.0 { -h } else { h };
        let [nu, nv] = self.exponents();
        let sin_sq = (h.x * h.x + h.y * h.y).max(1e-12);
        let exponent = (nu * h.x * h.x + nv * h.y * h.y) / sin_sq;
        let log = log_of_rest(f32x8::splat(sin_sq)).to_array()[0];
        let density = ((nu + 1.0) * (nv + 1.0)).sqrt() / TAU * (0.5 * exponent * log).exp();
        density / (4.0 * wi.dot(h).abs().max(1e-4))
    }
}

impl HalfVectorLobe for PhongLobe {
    fn half_vector(&self, _wo: Vec3, u: f32, v: f32) -> Vec3 {
        self.sample_half_vector(u, v)
    }

    fn density(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.pdf(wi, wo)
    }
}
