//! Blinn and Phong's model, normalized (Blinn 1977; Akenine-Möller et al. 2018, 9.8), over a diffuse base.
//!
//! `f = F (n + 2) (n + 4) / (8π (2^(-n/2) + n)) cosⁿ θh`: the factor makes the albedo equal F for light from the
//! normal. The exponent is `2 / alpha² - 2`, so lobes are as wide as microfacets of the same roughness.

use super::prelude::*;
use std::f32::consts::LN_2;

parameters! {
    /// Parameters of [`BlinnPhong`].
    pub struct BlinnPhongParameters {
        base_color: Vec3 = shared::BASE_COLOR,
        roughness: f32 = shared::ROUGHNESS,
        metalness: f32 = shared::METALNESS,
        specular: f32 = shared::SPECULAR,
        ior: f32 = shared::IOR,
    }
}

/// A power of the half vector's cosine over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct BlinnPhong {
    lobe: PhongLobe,
    schlick: Schlick,
    base: DiffuseBase,
}

impl BlinnPhong {
    /// Parameters must be within their ranges.
    #[inline]
    pub fn new(p: &BlinnPhongParameters) -> Self {
        let schlick = Schlick::new(p.base_color, p.metalness, p.ior, p.specular);
        let above = Albedo::of_smooth_dielectric(p.ior).scaled(p.specular);
        Self { lobe: PhongLobe::new(widths(p.roughness, 0.0)), base: DiffuseBase::new(schlick.diffuse, above), schlick }
    }

    fn glossy_share(&self, wo: Vec3) -> f32 {
        let fresnel = self.schlick.fresnel(f32x8::splat(wo.z.max(0.0))).lane(0);
        glossy_share(luminance(fresnel), luminance(self.base.own_albedo()))
    }
}

impl Model for BlinnPhong {
    const LABEL: &'static str = "Blinn-Phong";
    const SUMMARY: &'static str = "The classic highlight of older renderers and engines, normalized. Dark toward grazing angles; use GGX for metals.";
    const PARAMETERS: &'static [Parameter] = BlinnPhongParameters::LIST;

    #[inline]
    fn from_values(values: &Values) -> Self {
        Self::new(&BlinnPhongParameters::new(values))
    }
}

impl Brdf for BlinnPhong {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let half = HalfVectors::new(lights.wi, wo);
        let filtered = self.lobe.filtered(&half, lights, wo);
        let n = filtered.exponent();
        let two_to = (n * L::splat(-0.5 * LN_2)).exp();
        let factor = (n + L::splat(2.0)) * (n + L::splat(4.0)) * L::splat(0.125 * FRAC_1_PI) / (two_to + n);
        let lobe = factor * filtered.power * lights.wi.z * lights.above;
        (self.schlick.fresnel(half.wi_dot_h) * lobe + self.base.reflect(lights, wo)) * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        [self.lobe.alpha(), NO_LOBE, NO_LOBE]
    }

    fn albedo(&self) -> Vec3 {
        self.schlick.f0 + self.base.albedo_at(1.0)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        self.lobe.sample_over_base(self.glossy_share(wo), wo, u)
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.lobe.pdf_over_base(self.glossy_share(wo), wi, wo)
    }
}
