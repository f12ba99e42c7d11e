//! Reflectance models, evaluated eight light directions at a time.
//!
//! Directions are in the local frame: +Z the shading normal, +X the tangent. One implementation serves the merged cut, the
//! references and the tests. A new model is a file here, a variant of [`BrdfModel`] and of [`SurfaceBrdf`].

mod ggx;
mod lambert;
mod lights;
mod microfacet;
mod ward;

pub use ggx::Ggx;
pub use lambert::Lambert;
pub use lights::{CosinesX8, LightsX8, LobeMomentsX8};
pub use microfacet::{LOBE_LOSS, LobeWidth, MIN_ALPHA};
pub use ward::Ward;

use crate::{
    material::{BrdfModel, BrdfParameters},
    simd::{Lanes, Vec3x8},
};
use glam::Vec3;
use wide::f32x8;

/// A reflectance model with its parameters.
pub trait Brdf {
    /// `f_r(wi, wo) cos θi` per colour for eight lights.
    ///
    /// The spread of a light widens the lobe: the value is then close to the mean over the light's directions. Its cosine
    /// is that of the diffuse part.
    ///
    /// In the lanes of any instruction set, for a [`Kernel`](crate::simd::Kernel): so it is inlined always.
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L>
    where
        Self: Sized;

    /// [`Self::reflect`] for lights at the directions `wi`, with their cosines; zero below the horizon. A spread of zero
    /// gives the BRDF itself.
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8;

    /// Width of the narrowest lobe, if the model has one: how finely light directions must be resolved.
    fn lobe(&self) -> Option<LobeWidth>;

    /// Albedo for light from the normal: the share of light that a bounce reflects.
    fn albedo(&self) -> Vec3;

    /// A light direction for importance sampling, from three numbers in [0, 1). It may lie below the horizon.
    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3;

    /// Density of [`Self::sample`] per solid angle.
    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32;

    /// [`Self::brdf_cos_x8`] for one direction.
    fn brdf_cos(&self, wi: Vec3, wo: Vec3) -> Vec3 {
        self.brdf_cos_x8(Vec3x8::splat(wi), wo, f32x8::ZERO).lane(0)
    }
}

/// Any of the models, by value.
#[derive(Clone, Copy, Debug)]
pub enum SurfaceBrdf {
    /// See [`Lambert`].
    Lambert(Lambert),
    /// See [`Ggx`].
    Ggx(Ggx),
    /// See [`Ward`].
    Ward(Ward),
}

impl SurfaceBrdf {
    /// The model with parameters within their ranges, see [`BrdfParameters::sanitized`]: the code that applies the maps
    /// clamps them, once.
    pub fn new(model: BrdfModel, p: BrdfParameters) -> Self {
        match model {
            BrdfModel::Lambert => Self::Lambert(Lambert::new(p.base_color)),
            BrdfModel::Ggx => Self::Ggx(Ggx::new(&p)),
            BrdfModel::Ward => Self::Ward(Ward::new(&p)),
        }
    }

    /// The model behind the variant.
    #[inline(always)]
    pub fn as_brdf(&self) -> &dyn Brdf {
        match self {
            Self::Lambert(b) => b,
            Self::Ggx(b) => b,
            Self::Ward(b) => b,
        }
    }
}

#[cfg(test)]
mod tests;
