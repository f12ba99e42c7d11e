//! Cook-Torrance with Beckmann's distribution over a diffuse base (Cook and Torrance 1982; Walter et al. 2007).
//!
//! `f = F D G / (4 |n·wi| |n·wo|)` with normally distributed slopes, the exact Fresnel factor at the half vector, and
//! the rational fit of Smith's shadowing, uncorrelated (Walter et al., Eq. 27).

use super::GgxParameters;
use super::prelude::*;

/// Beckmann's lobe with Fresnel over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct Beckmann {
    lobe: GaussianLobe,
    interface: Interface,
    base: DiffuseBase,
}

impl Beckmann {
    /// Parameters must be within their ranges.
    #[inline]
    pub fn new(p: &GgxParameters) -> Self {
        let above = Albedo::of_smooth_dielectric(p.ior).scaled(p.specular);
        Self {
            lobe: GaussianLobe::new(widths(p.roughness, p.anisotropy)),
            interface: Interface::new(p.base_color, p.edge_color, p.metalness, p.ior, p.specular),
            base: DiffuseBase::new(p.base_color * (1.0 - p.metalness), above),
        }
    }

    fn glossy_share(&self, wo: Vec3) -> f32 {
        let fresnel = self.interface.fresnel(f32x8::splat(wo.z.max(0.0))).lane(0);
        glossy_share(luminance(fresnel), luminance(self.base.own_albedo()))
    }
}

impl Model for Beckmann {
    const LABEL: &'static str = "Beckmann";
    const SUMMARY: &'static str =
        "Cook and Torrance's microfacets: Fresnel over a diffuse base, as GGX, but highlights without long tails.";
    const PARAMETERS: &'static [Parameter] = GgxParameters::LIST;

    #[inline]
    fn from_values(values: &Values) -> Self {
        Self::new(&GgxParameters::new(values))
    }
}

impl Brdf for Beckmann {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let wi = lights.wi;
        let half = HalfVectors::new(wi, wo);
        let filtered = self.lobe.filtered(&half, lights, wo);
        let d = filtered.density / (filtered.cos_h_sq * filtered.cos_h_sq);
        let cos_o = L::splat(wo.z.max(1e-4));
        let shadowed = shadowing(&filtered.alpha_sq, wi.x, wi.y, wi.z.at_least(0.0))
            * shadowing(&filtered.alpha_sq, L::splat(wo.x), L::splat(wo.y), cos_o);
        let lobe = d * shadowed * L::splat(0.25) / cos_o * lights.above;
        (self.interface.fresnel(half.wi_dot_h) * lobe + self.base.reflect(lights, wo)) * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        [self.lobe.alpha(), NO_LOBE, NO_LOBE]
    }

    fn albedo(&self) -> Vec3 {
        let kept = Albedo::of_beckmann(self.lobe.alpha()).at_one(1.0);
        self.interface.at_normal() * kept + self.base.albedo_at(1.0)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        self.lobe.sample_over_base(self.glossy_share(wo), wo, u)
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.lobe.pdf_over_base(self.glossy_share(wo), wi, wo)
    }
}
