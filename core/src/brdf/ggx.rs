//! GGX microfacets over a diffuse base, in the metallic-roughness parametrization of glTF.
//!
//! `f = F D G / (4 |n·wi| |n·wo|)` with the exact Fresnel factor at the half vector and Smith's height-correlated
//! shadowing, see [`GgxLobe`](super::ggx_lobe::GgxLobe). A metal's loss between facets is restored (Kulla and Conty
//! 2017), and the base reflects the light that a dielectric leaves: under uniform light of 1 a white material shows 1.

use super::prelude::*;

parameters! {
    /// Parameters of [`Ggx`] and [`Beckmann`](super::Beckmann).
    pub struct GgxParameters {
        base_color: Vec3 = shared::BASE_COLOR,
        roughness: f32 = shared::ROUGHNESS,
        metalness: f32 = shared::METALNESS,
        specular: f32 = shared::SPECULAR,
        ior: f32 = shared::IOR,
        anisotropy: f32 = shared::ANISOTROPY,
        edge_color: Vec3 = shared::EDGE_COLOR,
    }
}

/// GGX with Fresnel over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    lobe: GgxLobe,
    interface: Interface,
    base: DiffuseBase,
    /// Directional albedo of the lobe alone.
    whole: Albedo,
    /// Restored part of the lobe's energy loss, over `1 - mean E`.
    multiple: Vec3,
}

impl Ggx {
    /// Parameters must be within their ranges.
    #[inline]
    pub fn new(p: &GgxParameters) -> Self {
        let lobe = GgxLobe::new(widths(p.roughness, p.anisotropy));
        let interface = Interface::new(p.base_color, p.edge_color, p.metalness, p.ior, p.specular);
        let whole = Albedo::of_ggx(lobe.alpha());
        let above = Albedo::of_dielectric(lobe.alpha(), p.ior).scaled(p.specular);
        let (mean, metal) = interface.mean_of_metal();
        let multiple = multiple_reflectance(mean, &whole) * (metal * whole.normalization());
        Self { lobe, interface, base: DiffuseBase::new(p.base_color * (1.0 - p.metalness), above), whole, multiple }
    }

    fn glossy_share(&self, wo: Vec3) -> f32 {
        let fresnel = self.interface.fresnel(f32x8::splat(wo.z.max(0.0))).lane(0);
        glossy_share(luminance(fresnel), luminance(self.base.own_albedo()))
    }
}

impl Model for Ggx {
    const LABEL: &'static str = "GGX";
    const SUMMARY: &'static str =
        "Microfacets with Fresnel over a diffuse base, as in glTF and most renderers. Highlights with long tails.";
    const PARAMETERS: &'static [Parameter] = GgxParameters::LIST;

    #[inline]
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
        let half = HalfVectors::new(lights.wi, wo);
        let single = self.interface.fresnel(half.wi_dot_h) * self.lobe.reflect(lights, &half, wo);
        let mut value = single;
        if self.multiple != Vec3::ZERO {
            let lost = self.whole.left(lights.wi.z, L::splat(wo.z));
            value = value + Vec3x8::splat(self.multiple * FRAC_1_PI) * (lost * lights.cosine);
        }
        if self.base.own_albedo() != Vec3::ZERO {
            value = value + self.base.reflect(lights, wo);
        }
        value * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        [self.lobe.alpha(), NO_LOBE, NO_LOBE]
    }

    fn albedo(&self) -> Vec3 {
        let whole = self.whole.at_one(1.0);
        let multiple = self.multiple * ((1.0 - whole) / self.whole.normalization());
        self.interface.at_normal() * whole + multiple + self.base.albedo_at(1.0)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        self.lobe.sample_over_base(self.glossy_share(wo), wo, u)
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.lobe.pdf_over_base(self.glossy_share(wo), wi, wo)
    }
}
