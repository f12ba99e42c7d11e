//! Shared parts of the microfacet models: anisotropic widths, the filtered lobe, and Fresnel.

use super::GgxParameters;
use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;

/// Narrowest lobe that is evaluated: for narrower ones, `f32` half vectors are too coarse for the peak.
pub const MIN_ALPHA: f32 = 1e-3;

/// Loss of a GGX lobe by shadowing and masking, for light from the normal: factors of the second to fourth power of
/// alpha.
pub const LOBE_LOSS: [f32; 3] = [1.05, 1.75, -0.55];

/// Microfacet widths along the tangent and the bitangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeWidth {
    /// Along +X.
    pub alpha_x: f32,
    /// Along +Y.
    pub alpha_y: f32,
}

impl LobeWidth {
    /// `alpha = roughness²`, stretched by the anisotropy as in Burley 2012: aspect `sqrt(1 - 0.9 |anisotropy|)`.
    pub fn new(roughness: f32, anisotropy: f32) -> Self {
        let alpha = roughness * roughness;
        let aspect = (1.0 - 0.9 * anisotropy.abs()).sqrt();
        let (long, short) = ((alpha / aspect).clamp(MIN_ALPHA, 1.0), (alpha * aspect).clamp(MIN_ALPHA, 1.0));
        if anisotropy >= 0.0 { Self { alpha_x: long, alpha_y: short } } else { Self { alpha_x: short, alpha_y: long } }
    }

    /// The narrower of the two.
    pub fn narrow(&self) -> f32 {
        self.alpha_x.min(self.alpha_y)
    }
}

/// Eight symmetric 2 x 2 matrices over the local x and y.
#[derive(Clone, Copy)]
pub(super) struct Sym2x8<L> {
    pub xx: L,
    pub xy: L,
    pub yy: L,
}

impl<L: Lanes> Sym2x8<L> {
    #[inline(always)]
    pub fn determinant(&self) -> L {
        self.xx * self.yy - self.xy * self.xy
    }

    /// `vᵀ M v`.
    #[inline(always)]
    pub fn quadratic(&self, x: L, y: L) -> L {
        self.xx * x * x + self.xy * x * y * L::splat(2.0) + self.yy * y * y
    }

    /// `vᵀ M⁻¹ v · det M`.
    #[inline(always)]
    pub fn adjugate_quadratic(&self, x: L, y: L) -> L {
        self.yy * x * x - self.xy * x * y * L::splat(2.0) + self.xx * y * y
    }
}

/// Half vectors and what comes with them.
pub(super) struct HalfVectors<L> {
    /// Unit half vectors.
    pub h: Vec3x8<L>,
    /// `wi · h = wo · h`.
    pub wi_dot_h: L,
}

impl<L: Lanes> HalfVectors<L> {
    #[inline(always)]
    pub fn new(wi: Vec3x8<L>, wo: Vec3) -> Self {
        let sum = wi + Vec3x8::splat(wo);
        let length = sum.dot(sum).at_least(1e-12).sqrt();
        let h = sum * (L::splat(1.0) / length);
        Self { h, wi_dot_h: L::splat(0.5) * length }
    }

    /// `(2 / κ) J Jᵀ`, where `J` is the Jacobian from light direction to the x and y of the half vector.
    ///
    /// With `a = wi · h` and `q = wi - a h`, `J Jᵀ` is the upper left block of `(I - h hᵀ - q qᵀ) / (4 a²)`:
    /// the tangent plane of the half vector, foreshortened along the plane of incidence.
    #[inline(always)]
    pub fn light_spread(&self, wi: Vec3x8<L>, inv_kappa: L) -> Sym2x8<L> {
        let q = wi - self.h * self.wi_dot_h;
        let scale = inv_kappa * L::splat(0.5) / (self.wi_dot_h * self.wi_dot_h).at_least(1e-4);
        Sym2x8 {
            xx: scale * (L::splat(1.0) - self.h.x * self.h.x - q.x * q.x),
            xy: -scale * (self.h.x * self.h.y + q.x * q.y),
            yy: scale * (L::splat(1.0) - self.h.y * self.h.y - q.y * q.y),
        }
    }
}

/// Normal-incidence reflectance, its value at grazing incidence, and diffuse albedo of a metallic-roughness material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectance {
    pub f0: Vec3,
    pub f90: f32,
    pub diffuse: Vec3,
}

impl Reflectance {
    pub fn new(p: &GgxParameters) -> Self {
        let dielectric = ((p.ior - 1.0) / (p.ior + 1.0)).powi(2) * p.specular;
        Self {
            f0: Vec3::splat(dielectric).lerp(p.base_color, p.metalness),
            f90: p.specular + (1.0 - p.specular) * p.metalness,
            diffuse: p.base_color * (1.0 - p.metalness),
        }
    }

    /// Albedo of a GGX lobe of width `alpha` for light from the normal, without light lost to shadowing and masking.
    /// The rational function is within 0.005 of the integral over all `alpha`.
    #[inline]
    pub fn lobe_albedo(&self, alpha: f32) -> Vec3 {
        let [second, third, fourth] = LOBE_LOSS;
        self.f0 / (1.0 + alpha * alpha * (second + third * alpha + fourth * alpha * alpha))
    }

    /// Schlick's Fresnel factor for eight angles.
    #[inline(always)]
    pub fn fresnel<L: Lanes>(&self, wi_dot_h: L) -> Vec3x8<L> {
        let c = (L::splat(1.0) - wi_dot_h).at_least(0.0);
        let c2 = c * c;
        let grazing = c2 * c2 * c;
        let f0 = Vec3x8::splat(self.f0);
        f0 + (Vec3x8::splat(Vec3::splat(self.f90)) - f0) * grazing
    }
}

/// 1 if the surface faces the eye, else 0.
#[inline(always)]
pub(super) fn is_seen<L: Lanes>(wo: Vec3) -> L {
    L::splat(if wo.z > 0.0 { 1.0 } else { 0.0 })
}
