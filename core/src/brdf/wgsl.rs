//! A user's BRDF in WGSL. See [`Written`].
//!
//! A function has no filtered lobe. Lights wide relative to its lobe take a mean over four directions.

use super::{
    Brdf, FilePart, LightsX8, Lobes, Model, NO_LOBE, Parameter, Values,
    lambert::Lambert,
    merl::MISSING,
    sampled::SampledLobe,
    written::{Arguments, Written},
};
use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use std::{f32::consts::FRAC_1_PI, sync::Arc};
use wide::f32x8;

/// Spread of a light, in squared widths of the lobe, above which directions are averaged.
pub const WIDE_LIGHT: f32 = 0.1;

/// A user's BRDF with its parameters; diffuse magenta if its file is missing.
#[derive(Clone, Debug)]
pub struct Wgsl {
    written: Option<Loaded>,
}

#[derive(Clone, Debug)]
struct Loaded {
    written: Arc<Written>,
    arguments: Arguments,
    estimate: Arc<SampledLobe>,
}

impl Loaded {
    /// BRDF for light around `wi`; magenta where the value is not a reflectance. Twin of the function that
    /// `render/src/device/written.rs` writes.
    fn mean(&self, wi: Vec3, wo: Vec3, inv_kappa: f32) -> Vec3 {
        let width = self.estimate.width();
        let at = |wi: Vec3| self.written.value(&self.arguments, wi, wo).unwrap_or(MISSING * FRAC_1_PI);
        if !(width > 0.0 && inv_kappa > WIDE_LIGHT * width * width) {
            return at(wi);
        }
        // Four directions match the variance of the light.
        let radius = (2.0 * inv_kappa).sqrt().min(1.0);
        let side = if wi.z.abs() > 0.9 { Vec3::X } else { Vec3::Z };
        let tangent = wi.cross(side).normalize();
        let bitangent = wi.cross(tangent);
        let around = [tangent, -tangent, bitangent, -bitangent].map(|offset| at(above(wi + offset * radius)));
        around.into_iter().sum::<Vec3>() * 0.25
    }
}

/// The direction, raised to the horizon if it is below.
fn above(wi: Vec3) -> Vec3 {
    Vec3::new(wi.x, wi.y, wi.z.max(1e-3)).normalize_or(Vec3::Z)
}

impl Model for Wgsl {
    const LABEL: &'static str = "Written in WGSL";
    const SUMMARY: &'static str =
        "Your own function in a .wgsl file, which declares its parameters. A changed file is reloaded.";
    /// The file declares the parameters.
    const PARAMETERS: &'static [Parameter] = &[];

    fn from_values(_: &Values) -> Self {
        Self { written: None }
    }

    fn of_file(values: &Values, file: Option<FilePart>) -> Self {
        let loaded = |FilePart { content, plain }: FilePart| {
            let written = content.written()?;
            let (arguments, estimate) = (written.arguments(values), written.estimate(plain));
            Some(Loaded { written: written.clone(), arguments, estimate })
        };
        Self { written: file.and_then(loaded) }
    }
}

impl Brdf for Wgsl {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let Some(loaded) = &self.written else { return Lambert::new(MISSING).reflect(lights, wo) };
        let [x, y, z] = [lights.wi.x, lights.wi.y, lights.wi.z].map(L::to_array);
        // Slopes turn the mirror direction by twice their angle, four times their variance; `slopes` already holds
        // twice the variance.
        let [xx, _, yy] = lights.spread.slopes;
        let (spread, cosine) = ((lights.spread.inv_kappa + xx + yy).to_array(), lights.cosine.to_array());
        let mut values = [Vec3::ZERO; 8];
        for i in 0..8 {
            if cosine[i] > 0.0 && wo.z > 0.0 {
                values[i] = loaded.mean(above(Vec3::new(x[i], y[i], z[i])), wo, spread[i]) * cosine[i];
            }
        }
        Vec3x8::from_array(values)
    }

    fn lobes(&self) -> Lobes {
        self.written.as_ref().map_or([NO_LOBE; 3], |loaded| loaded.estimate.lobes())
    }

    fn albedo(&self) -> Vec3 {
        self.written.as_ref().map_or(MISSING, |loaded| loaded.estimate.albedo_at(1.0))
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        match &self.written {
            Some(loaded) => loaded.estimate.sample(wo, u),
            None => Lambert::new(MISSING).sample(wo, u),
        }
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        match &self.written {
            Some(loaded) => loaded.estimate.pdf(wi, wo),
            None => Lambert::new(MISSING).pdf(wi, wo),
        }
    }
}
