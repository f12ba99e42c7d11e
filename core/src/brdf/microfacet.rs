//! Common parts of glossy models: widths, half vectors, and the split of light between a lobe and a diffuse base.

use super::{
    SpreadX8,
    fresnel::{Metal, dielectric_x8},
};
use crate::{
    simd::{Lanes, Vec3x8},
    sphere::cosine_direction,
};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Narrowest lobe: below it, `f32` half vectors are too coarse for the peak.
pub const MIN_ALPHA: f32 = 1e-3;

/// Microfacet widths along the tangent and the bitangent: `alpha = roughness²`, stretched by the anisotropy as in Burley
/// 2012, aspect `sqrt(1 - 0.9 |anisotropy|)`.
pub fn widths(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let alpha = roughness * roughness;
    let aspect = (1.0 - 0.9 * anisotropy.abs()).sqrt();
    let (long, short) = ((alpha / aspect).clamp(MIN_ALPHA, 1.0), (alpha * aspect).clamp(MIN_ALPHA, 1.0));
    if anisotropy >= 0.0 { [long, short] } else { [short, long] }
}

/// Eight symmetric 2 x 2 matrices over the local x and y.
#[derive(Clone, Copy)]
pub struct Sym2x8<L> {
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

/// Half vectors and derived quantities, by one division and one root.
pub struct HalfVectors<L> {
    /// `wi + wo`, of any length.
    sum: Vec3x8<L>,
    /// One over the squared length of the sum.
    inv_length_sq: L,
    /// `wi · h = wo · h`, half the length of the sum.
    pub wi_dot_h: L,
}

impl<L: Lanes> HalfVectors<L> {
    #[inline(always)]
    pub fn new(wi: Vec3x8<L>, wo: Vec3) -> Self {
        let sum = wi + Vec3x8::splat(wo);
        let length_sq = sum.dot(sum).at_least(1e-12);
        Self { sum, inv_length_sq: L::splat(1.0) / length_sq, wi_dot_h: L::splat(0.5) * length_sq.sqrt() }
    }

    /// Squared cosines of the half vectors to the normal.
    #[inline(always)]
    pub fn cos_sq(&self) -> L {
        self.sum.z * self.sum.z * self.inv_length_sq
    }

    /// Squared sines of the half vectors to the normal.
    #[inline(always)]
    pub fn sin_sq(&self) -> L {
        (self.sum.x * self.sum.x + self.sum.y * self.sum.y) * self.inv_length_sq
    }

    /// `hᵀ M⁻¹ h · det M` over the x and y of the half vectors.
    #[inline(always)]
    pub fn adjugate_quadratic(&self, m: &Sym2x8<L>) -> L {
        m.adjugate_quadratic(self.sum.x, self.sum.y) * self.inv_length_sq
    }

    /// `(2 / κ) J Jᵀ`, where `J` is the Jacobian from light direction to the x and y of the half vector, plus twice the
    /// covariance of the surface's slopes: both move the half vector relative to the normals of the lobe.
    ///
    /// With `a = wi · h` and `q = wi - a h`, which is half of `wi - wo`, `J Jᵀ` is the upper left block of
    /// `(I - h hᵀ - q qᵀ) / (4 a²)`: the tangent plane of the half vector, foreshortened along the plane of incidence.
    #[inline(always)]
    pub fn spread(&self, wi: Vec3x8<L>, wo: Vec3, spread: &SpreadX8<L>) -> Sym2x8<L> {
        let half = L::splat(0.5);
        let (qx, qy) = (half * (wi.x - L::splat(wo.x)), half * (wi.y - L::splat(wo.y)));
        let (hx, hy) = (self.sum.x * self.inv_length_sq, self.sum.y * self.inv_length_sq);
        let [xx, xy, yy] = spread.slopes;
        // 1 / (2 a²), where a² is at least 1e-4.
        let scale = spread.inv_kappa * (self.inv_length_sq + self.inv_length_sq).fast_min(L::splat(5e3));
        Sym2x8 {
            xx: xx + scale * (L::splat(1.0) - hx * self.sum.x - qx * qx),
            xy: xy - scale * (hx * self.sum.y + qx * qy),
            yy: yy + scale * (L::splat(1.0) - hy * self.sum.y - qy * qy),
        }
    }
}

/// Schlick's Fresnel factor and the diffuse albedo of a metallic-roughness material.
#[derive(Clone, Copy, Debug)]
pub struct Schlick {
    /// Reflectance at normal incidence.
    pub f0: Vec3,
    /// Reflectance at grazing incidence.
    pub f90: f32,
    /// Albedo of the base below.
    pub diffuse: Vec3,
}

impl Schlick {
    pub fn new(base_color: Vec3, metalness: f32, ior: f32, specular: f32) -> Self {
        let dielectric = ((ior - 1.0) / (ior + 1.0)).powi(2) * specular;
        Self {
            f0: Vec3::splat(dielectric).lerp(base_color, metalness),
            f90: specular + (1.0 - specular) * metalness,
            diffuse: base_color * (1.0 - metalness),
        }
    }

    /// Factors for eight angles.
    #[inline(always)]
    pub fn fresnel<L: Lanes>(&self, wi_dot_h: L) -> Vec3x8<L> {
        let c = (L::splat(1.0) - wi_dot_h).at_least(0.0);
        let c2 = c * c;
        let grazing = c2 * c2 * c;
        let f0 = Vec3x8::splat(self.f0);
        f0 + (Vec3x8::splat(Vec3::splat(self.f90)) - f0) * grazing
    }
}

/// Exact Fresnel factor of a dielectric, a metal, or a mixture of both for transitions in maps.
#[derive(Clone, Copy, Debug)]
pub struct Interface {
    ior: f32,
    /// Weights of the dielectric and of the metal.
    weights: [f32; 2],
    metal: Metal,
}

impl Interface {
    /// `specular` scales the dielectric's reflection.
    #[inline]
    pub fn new(base_color: Vec3, edge_color: Vec3, metalness: f32, ior: f32, specular: f32) -> Self {
        let metal = if metalness > 0.0 { Metal::new(base_color, edge_color) } else { Metal::default() };
        Self { ior, weights: [specular * (1.0 - metalness), metalness], metal }
    }

    /// Factors for eight angles to the half vector.
    #[inline(always)]
    pub fn fresnel<L: Lanes>(&self, wi_dot_h: L) -> Vec3x8<L> {
        let [dielectric, metal] = self.weights;
        let mut all = Vec3x8::splat(Vec3::ZERO);
        if dielectric > 0.0 {
            let gray = L::splat(dielectric) * dielectric_x8(wi_dot_h, self.ior);
            all = Vec3x8 { x: gray, y: gray, z: gray };
        }
        if metal > 0.0 {
            all = all + self.metal.fresnel(wi_dot_h) * L::splat(metal);
        }
        all
    }

    /// Mean factor of the metal over all directions, and its weight.
    pub fn mean_of_metal(&self) -> (Vec3, f32) {
        (self.metal.mean(), self.weights[1])
    }

    /// Factor for light from the normal.
    pub fn at_normal(&self) -> Vec3 {
        self.fresnel(wide::f32x8::splat(1.0)).lane(0)
    }
}

/// `alpha² / (1 - alpha²)`: the widths of a lobe in projected slope space.
#[inline]
pub fn slopes(alpha: [f32; 2]) -> [f32; 2] {
    // An alpha of one has infinite slope width; 0.9999 is indistinguishable from it.
    let slope = |alpha: f32| {
        let sq = (alpha * alpha).min(0.9998);
        sq / (1.0 - sq)
    };
    alpha.map(slope)
}

/// A lobe with samplable half vectors.
pub trait HalfVectorLobe {
    /// A half vector for an outgoing direction, from two numbers in [0, 1).
    fn half_vector(&self, wo: Vec3, u: f32, v: f32) -> Vec3;
    /// Density of the light direction mirrored at the half vector, per solid angle.
    fn density(&self, wi: Vec3, wo: Vec3) -> f32;

    /// Samples a light direction by the lobe with probability `share`, else by the base below it.
    fn sample_over_base(&self, share: f32, wo: Vec3, u: Vec3) -> Vec3 {
        if u.z < share {
            let h = self.half_vector(wo, u.x, u.y);
            2.0 * wo.dot(h) * h - wo
        } else {
            cosine_direction(u.x, u.y)
        }
    }

    /// Density of [`Self::sample_over_base`].
    fn pdf_over_base(&self, share: f32, wi: Vec3, wo: Vec3) -> f32 {
        share * self.density(wi, wo) + (1.0 - share) * wi.z.max(0.0) * FRAC_1_PI
    }
}

/// Probability of sampling a glossy lobe beside a diffuse base, from the albedos of both.
pub fn glossy_share(glossy: f32, diffuse: f32) -> f32 {
    if glossy + diffuse > 0.0 { (glossy / (glossy + diffuse)).max(0.1) } else { 1.0 }
}

/// 1 if the surface faces the eye, else 0.
#[inline(always)]
pub fn is_seen<L: Lanes>(wo: Vec3) -> L {
    L::splat(if wo.z > 0.0 { 1.0 } else { 0.0 })
}
