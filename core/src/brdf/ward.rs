//! Ward's BRDF as he measured it (1992), isotropic and anisotropic.
//!
//! `f = diffuse / π + s exp(-((hx/αx)² + (hy/αy)²) / hz²) / (4π αx αy sqrt(n·wi n·wo))` for a unit half vector `h`. The model has
//! no Fresnel factor: `s` is the reflectance at normal incidence. It loses energy toward grazing angles.

use super::{
    Brdf, LightsX8, Lobes, Model, NO_LOBE, Parameter, Values,
    albedo::Albedo,
    gaussian_lobe::GaussianLobe,
    microfacet::{HalfVectorLobe, HalfVectors, Schlick, glossy_share, is_seen, widths},
    parameter::parameters,
    shared,
};
use crate::{
    color::luminance,
    simd::{Lanes, Vec3x8},
};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;
use wide::f32x8;

parameters! {
    /// Parameters of [`Ward`].
    pub struct WardParameters {
        base_color: Vec3 = shared::BASE_COLOR,
        roughness: f32 = shared::ROUGHNESS,
        metalness: f32 = shared::METALNESS,
        specular: f32 = shared::SPECULAR,
        ior: f32 = shared::IOR,
        anisotropy: f32 = shared::ANISOTROPY,
    }
}

/// Ward's lobe over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct Ward {
    lobe: GaussianLobe,
    specular: Vec3,
    diffuse: Vec3,
}

impl Ward {
    /// `p` must be within the ranges.
    #[inline]
    pub fn new(p: &WardParameters) -> Self {
        let Schlick { f0, diffuse, .. } = Schlick::new(p.base_color, p.metalness, p.ior, p.specular);
        // Light that the lobe reflects does not reach the base: the sum of both never exceeds one.
        let diffuse = diffuse * (1.0 - f0.max_element());
        Self { lobe: GaussianLobe::new(widths(p.roughness, p.anisotropy)), specular: f0, diffuse }
    }

    fn glossy_share(&self, _wo: Vec3) -> f32 {
        glossy_share(luminance(self.specular), luminance(self.diffuse))
    }
}

impl Model for Ward {
    const LABEL: &'static str = "Ward";
    const SUMMARY: &'static str =
        "Ward's lobe of 1992 over a diffuse base, without Fresnel. Dark toward grazing angles; Ward-Duer mends that.";
    const PARAMETERS: &'static [Parameter] = WardParameters::LIST;

    #[inline]
    fn from_values(values: &Values) -> Self {
        Self::new(&WardParameters::new(values))
    }
}

impl Brdf for Ward {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let half = HalfVectors::new(lights.wi, wo);
        let filtered = self.lobe.filtered(&half, lights, wo);
        let (cos_i, cos_o) = (lights.wi.z.at_least(0.0), wo.z.max(1e-4));
        let lobe = filtered.density * L::splat(0.25) * (cos_i * L::splat(1.0 / cos_o)).sqrt() * lights.above;
        let base = Vec3x8::splat(self.diffuse * FRAC_1_PI) * lights.cosine;
        (base + Vec3x8::splat(self.specular) * lobe) * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        [self.lobe.alpha(), NO_LOBE, NO_LOBE]
    }

    fn albedo(&self) -> Vec3 {
        self.diffuse + self.specular * Albedo::of_ward(self.lobe.alpha()).at_one(1.0)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        self.lobe.sample_over_base(self.glossy_share(wo), wo, u)
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.lobe.pdf_over_base(self.glossy_share(wo), wi, wo)
    }
}
