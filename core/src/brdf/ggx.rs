//! GGX microfacets (Walter et al. 2007, Heitz 2014) over a diffuse base, in the metallic-roughness parametrisation of glTF.
//!
//! `f = (1 - F) diffuse / π + F D G / (4 |n·wi| |n·wo|)` with Schlick's Fresnel factor at the half vector and Smith's
//! height-correlated shadowing. The filtered lobe follows Tokuyoshi et al. 2024 (*Hierarchical Light Sampling with
//! Accurate Spherical Gaussian Lighting*): in projected slope space the widths of lobe and light add up.

use super::{
    Brdf, LightsX8, Lobes, Model, Parameter, Values,
    microfacet::{HalfVectors, LobeWidth, Reflectance, Sym2x8, is_seen},
    parameter::parameters,
    shared,
};
use crate::{
    color::luminance,
    simd::{Lanes, Vec3x8},
    sphere::cosine_direction,
};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};
use wide::f32x8;

parameters! {
    /// Parameters of [`Ggx`].
    pub struct GgxParameters {
        base_color: Vec3 = shared::BASE_COLOR,
        roughness: f32 = shared::ROUGHNESS,
        metalness: f32 = shared::METALNESS,
        specular: f32 = shared::SPECULAR,
        ior: f32 = shared::IOR,
        anisotropy: f32 = shared::ANISOTROPY,
    }
}

/// GGX with Fresnel over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    reflectance: Reflectance,
    width: LobeWidth,
    /// `alpha² / (1 - alpha²)`: the lobe's width in projected slope space.
    slope_x: f32,
    slope_y: f32,
}

impl Ggx {
    /// `p` must be within the ranges.
    pub fn new(p: &GgxParameters) -> Self {
        let width = LobeWidth::new(p.roughness, p.anisotropy);
        // An alpha of one has infinite slope width; 0.9999 is indistinguishable from it.
        let slope = |alpha: f32| {
            let sq = (alpha * alpha).min(0.9998);
            sq / (1.0 - sq)
        };
        let reflectance = Reflectance::new(p);
        Self { reflectance, width, slope_x: slope(width.alpha_x), slope_y: slope(width.alpha_y) }
    }

    /// The isotropic width that is closest.
    fn alpha(&self) -> f32 {
        (self.width.alpha_x * self.width.alpha_y).sqrt()
    }

    /// Squared widths `alpha²` of the lobe filtered by the light's spread, a matrix.
    #[inline(always)]
    fn filtered_alpha_sq<L: Lanes>(&self, half: &HalfVectors<L>, wi: Vec3x8<L>, inv_kappa: L) -> Sym2x8<L> {
        let spread = half.light_spread(wi, inv_kappa);
        let (lobe_xx, lobe_yy) = (L::splat(self.slope_x), L::splat(self.slope_y));
        let a = Sym2x8 { xx: lobe_xx + spread.xx, xy: spread.xy, yy: lobe_yy + spread.yy };
        let determinant = a.determinant();
        let scale = L::splat(1.0) / (L::splat(1.0) + a.xx + a.yy + determinant);
        Sym2x8 { xx: (a.xx + determinant) * scale, xy: a.xy * scale, yy: (a.yy + determinant) * scale }
    }

    fn specular_probability(&self, wo: Vec3) -> f32 {
        let fresnel = self.reflectance.fresnel(f32x8::splat(wo.z.max(0.0))).lane(0);
        let (specular, diffuse) = (luminance(fresnel), luminance(self.reflectance.diffuse));
        if specular + diffuse > 0.0 { (specular / (specular + diffuse)).max(0.1) } else { 1.0 }
    }

    /// Visible normals (Heitz 2018, *Sampling the GGX Distribution of Visible Normals*).
    fn sample_half_vector(&self, wo: Vec3, u: f32, v: f32) -> Vec3 {
        let (ax, ay) = (self.width.alpha_x, self.width.alpha_y);
        let stretched = Vec3::new(ax * wo.x, ay * wo.y, wo.z).normalize();
        let (t1, t2) = stretched.any_orthonormal_pair();
        let r = u.sqrt();
        let (sin, cos) = (TAU * v).sin_cos();
        let s = 0.5 * (1.0 + stretched.z);
        // The pair must have t1 level, so that the half disc is the lower one.
        let (t1, t2) = if stretched.z < 0.9999 {
            let level = Vec3::Z.cross(stretched).normalize();
            (level, stretched.cross(level))
        } else {
            (t1, t2)
        };
        let p1 = r * cos;
        let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * r * sin;
        let n = t1 * p1 + t2 * p2 + stretched * (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        Vec3::new(ax * n.x, ay * n.y, n.z.max(1e-6)).normalize()
    }

    /// `D(h) G1(wo) / (4 n·wo)`: density of the light direction when half vectors are visible normals.
    fn specular_pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let h = (wi + wo).normalize_or(Vec3::Z);
        if !(h.z > 0.0) {
            return 0.0;
        }
        let (ax2, ay2) = (self.width.alpha_x.powi(2), self.width.alpha_y.powi(2));
        let e = h.x * h.x / ax2 + h.y * h.y / ay2 + h.z * h.z;
        let d = FRAC_1_PI / (self.width.alpha_x * self.width.alpha_y * e * e);
        let masked = wo.z + (wo.z * wo.z + ax2 * wo.x * wo.x + ay2 * wo.y * wo.y).sqrt();
        d / (2.0 * masked)
    }
}

impl Model for Ggx {
    const LABEL: &'static str = "GGX";
    const SUMMARY: &'static str =
        "Microfacets with Fresnel over a diffuse base, as in glTF and most renderers. Highlights with long tails.";
    const PARAMETERS: &'static [Parameter] = GgxParameters::LIST;

    fn from_values(values: &Values) -> Self {
        Self::new(&GgxParameters::new(values))
    }
}

impl Brdf for Ggx {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let LightsX8 { wi, inv_kappa, cosine, above } = *lights;
        let half = HalfVectors::new(wi, wo);
        let m = self.filtered_alpha_sq(&half, wi, inv_kappa);
        let determinant = m.determinant().at_least(1e-14);
        let h = half.h;
        let e = m.adjugate_quadratic(h.x, h.y) / determinant + h.z * h.z;
        let d = L::splat(FRAC_1_PI) / (determinant.sqrt() * e * e);
        let (cos_i, cos_o) = (wi.z.at_least(0.0), L::splat(wo.z.max(1e-4)));
        let (ox, oy) = (L::splat(wo.x), L::splat(wo.y));
        // Smith's G / (4 n·wi n·wo), times n·wi: both square roots of Heitz 2014, Eq. 99.
        let root_o = (cos_o * cos_o + m.quadratic(ox, oy)).sqrt();
        let root_i = (cos_i * cos_i + m.quadratic(wi.x, wi.y)).sqrt();
        let shadowed = L::splat(0.5) * cos_i / (cos_i * root_o + cos_o * root_i).at_least(1e-9);
        let fresnel = self.reflectance.fresnel(half.wi_dot_h);
        let diffuse = Vec3x8::splat(self.reflectance.diffuse * FRAC_1_PI);
        let base = (diffuse - diffuse.scale(fresnel)) * cosine;
        (base + fresnel * (d * shadowed * above)) * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        [self.width.narrow(), 0.0, 0.0]
    }

    fn albedo(&self) -> Vec3 {
        self.reflectance.diffuse * (Vec3::ONE - self.reflectance.f0) + self.reflectance.lobe_albedo(self.alpha())
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        if u.z < self.specular_probability(wo) {
            let h = self.sample_half_vector(wo, u.x, u.y);
            2.0 * wo.dot(h) * h - wo
        } else {
            cosine_direction(u.x, u.y)
        }
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let p = self.specular_probability(wo);
        p * self.specular_pdf(wi, wo) + (1.0 - p) * wi.z.max(0.0) * FRAC_1_PI
    }
}
