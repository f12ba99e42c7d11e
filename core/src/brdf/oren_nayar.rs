//! Rough diffuse reflection that preserves energy (Portsmouth, Kutz and Hill 2024, *EON: A Practical Energy-Preserving
//! Rough Diffuse BRDF*): Fujii's improved Oren-Nayar plus multiple scattering among its facets.

use super::prelude::*;
use std::f32::consts::PI;

parameters! {
    /// Parameters of [`OrenNayar`].
    pub struct OrenNayarParameters {
        base_color: Vec3 = shared::BASE_COLOR,
        diffuse_roughness: f32 = shared::DIFFUSE_ROUGHNESS,
    }
}

/// `1/2 - 2 / (3π)`.
const A: f32 = 0.5 - 2.0 / (3.0 * PI);
/// `2/3 - 28 / (15π)`.
const B: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);
/// The fit of the directional albedo in `1 - cos θ` (EON, Eq. 26).
const G: [f32; 4] = [0.057_108_53, 0.491_881_87, -0.332_181_44, 0.071_442_995];

/// Rough diffuse reflection.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    albedo: Vec3,
    roughness: f32,
    /// `1 / (1 + A r)`.
    scale: f32,
    /// Albedo of multiple scattering, over `1 - mean E`.
    multiple: Vec3,
}

impl OrenNayar {
    /// A surface of linear `albedo`, 0 to 1, and `roughness` from 0 (Lambertian) to 1.
    #[inline]
    pub fn new(albedo: Vec3, roughness: f32) -> Self {
        let scale = 1.0 / (1.0 + A * roughness);
        let mean = scale * (1.0 + B * roughness);
        let lost = (1.0 - mean).max(1e-7);
        let multiple = albedo * albedo * mean / (Vec3::ONE - albedo * (1.0 - mean)) / lost;
        Self { albedo, roughness, scale, multiple }
    }

    /// Directional albedo of single scattering by white facets.
    #[inline(always)]
    fn single_albedo<L: Lanes>(&self, cosine: L) -> L {
        let m = L::splat(1.0) - cosine.at_least(0.0).fast_min(L::splat(1.0));
        let [a, b, c, d] = G;
        let g = m * (L::splat(a) + m * (L::splat(b) + m * (L::splat(c) + m * L::splat(d))));
        (L::splat(1.0) + L::splat(self.roughness) * g) * L::splat(self.scale)
    }

    /// The BRDF, without the cosine.
    #[inline(always)]
    pub fn value<L: Lanes>(&self, wi: Vec3x8<L>, wo: Vec3) -> Vec3x8<L> {
        let (cos_i, cos_o) = (wi.z.at_least(0.0), L::splat(wo.z.max(0.0)));
        let s = wi.dot(Vec3x8::splat(wo)) - cos_i * cos_o;
        let s_over_t = s.simd_gt(L::splat(0.0)).select(s / cos_i.fast_max(cos_o).at_least(1e-4), s);
        let single = (L::splat(1.0) + L::splat(self.roughness) * s_over_t) * L::splat(self.scale * FRAC_1_PI);
        let lost = (L::splat(1.0) - self.single_albedo(cos_i)) * (L::splat(1.0) - self.single_albedo(cos_o));
        Vec3x8::splat(self.albedo) * single + Vec3x8::splat(self.multiple * FRAC_1_PI) * lost.at_least(0.0)
    }

    /// Albedo for light from a direction with this cosine.
    pub fn albedo_at(&self, cosine: f32) -> Vec3 {
        let single = self.single_albedo(f32x8::splat(cosine)).to_array()[0];
        let mean = self.scale * (1.0 + B * self.roughness);
        self.albedo * single + self.multiple * ((1.0 - single) * (1.0 - mean))
    }
}

impl Model for OrenNayar {
    const LABEL: &'static str = "Oren-Nayar";
    const SUMMARY: &'static str = "Rough diffuse reflection that keeps all energy: clay, stone, cloth, the moon.";
    const PARAMETERS: &'static [Parameter] = OrenNayarParameters::LIST;

    fn from_values(values: &Values) -> Self {
        let p = OrenNayarParameters::new(values);
        Self::new(p.base_color, p.diffuse_roughness)
    }
}

impl Brdf for OrenNayar {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        self.value(lights.wi, wo) * (lights.cosine * is_seen(wo))
    }

    fn lobes(&self) -> Lobes {
        [NO_LOBE; 3]
    }

    fn albedo(&self) -> Vec3 {
        self.albedo_at(1.0)
    }

    fn sample(&self, _wo: Vec3, u: Vec3) -> Vec3 {
        cosine_direction(u.x, u.y)
    }

    fn pdf(&self, wi: Vec3, _wo: Vec3) -> f32 {
        wi.z.max(0.0) * FRAC_1_PI
    }
}
