//! Ashikhmin and Shirley's anisotropic Phong model (2000), with its own diffuse base.
//!
//! `f = sqrt((nu + 1) (nv + 1)) / (8π) cosⁿ θh F / ((wi·h) max(n·wi, n·wo))` and, below it,
//! `28 / (23π) diffuse (1 - f0) (1 - (1 - n·wi / 2)⁵) (1 - (1 - n·wo / 2)⁵)` (Eq. 4 and 5). The exponents are
//! `2 / alpha² - 2`, so lobes are as wide as microfacets of the same roughness.

use super::prelude::*;
use super::shared::GlossyParameters;

/// Two powers of the half vector's cosine over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct AshikhminShirley {
    lobe: PhongLobe,
    schlick: Schlick,
}

impl AshikhminShirley {
    /// Parameters must be within their ranges.
    #[inline]
    pub fn new(p: &GlossyParameters) -> Self {
        Self {
            lobe: PhongLobe::new(widths(p.roughness, p.anisotropy)),
            schlick: Schlick::new(p.base_color, p.metalness, p.ior, p.specular),
        }
    }

    fn glossy_share(&self, wo: Vec3) -> f32 {
        let fresnel = self.schlick.fresnel(f32x8::splat(wo.z.max(0.0))).lane(0);
        glossy_share(luminance(fresnel), luminance(self.schlick.diffuse))
    }

    /// Albedo of the base below white facets, for light from the normal.
    fn base(&self) -> Vec3 {
        self.schlick.diffuse * (Vec3::ONE - self.schlick.f0) * (28.0 / 23.0)
    }
}

/// `1 - (1 - cos / 2)⁵`.
#[inline(always)]
fn reached<L: Lanes>(cosine: L) -> L {
    let m = L::splat(1.0) - L::splat(0.5) * cosine;
    let m2 = m * m;
    L::splat(1.0) - m2 * m2 * m
}

impl Model for AshikhminShirley {
    const LABEL: &'static str = "Ashikhmin-Shirley";
    const SUMMARY: &'static str =
        "An anisotropic Phong lobe with Fresnel over a base that keeps energy: brushed metals and polished plastics.";
    const PARAMETERS: &'static [Parameter] = GlossyParameters::LIST;

    #[inline]
    fn from_values(values: &Values) -> Self {
        Self::new(&GlossyParameters::new(values))
    }
}

impl Brdf for AshikhminShirley {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let half = HalfVectors::new(lights.wi, wo);
        let filtered = self.lobe.filtered(&half, lights, wo);
        let (cos_i, cos_o) = (lights.wi.z.at_least(0.0), L::splat(wo.z.max(1e-4)));
        let below = half.wi_dot_h.at_least(1e-4) * cos_i.fast_max(cos_o);
        let factor = filtered.two_exponents() * L::splat(0.125 * FRAC_1_PI) / below;
        let lobe = factor * filtered.power * cos_i * lights.above;
        let base = Vec3x8::splat(self.base() * FRAC_1_PI) * (reached(cos_i) * reached(cos_o) * lights.cosine);
        (self.schlick.fresnel(half.wi_dot_h) * lobe + base) * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        [self.lobe.alpha(), NO_LOBE, NO_LOBE]
    }

    fn albedo(&self) -> Vec3 {
        // Mean of cos 2θh over half vectors of up to 45°; larger angles reflect light from the normal below the horizon.
        let n = self.lobe.mean_exponent();
        let up_to = |power: f32| 1.0 - 0.5_f32.powf(0.5 * power);
        let kept = 2.0 * (n + 1.0) / (n + 3.0) * up_to(n + 3.0) - up_to(n + 1.0);
        self.schlick.f0 * kept + self.base() * (31.0 / 32.0 * 23.0 / 28.0)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        self.lobe.sample_over_base(self.glossy_share(wo), wo, u)
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.lobe.pdf_over_base(self.glossy_share(wo), wi, wo)
    }
}
