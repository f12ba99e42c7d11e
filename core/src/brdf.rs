//! Reflectance models, evaluated eight light directions at a time.
//!
//! Directions are in the local frame: +Z the shading normal, +X the tangent. One implementation serves the merged cut,
//! the references and the tests. `models.rs` lists all models; each declares its parameters.

mod albedo;
mod ashikhmin_shirley;
mod beckmann;
mod blinn_phong;
mod content;
mod diffuse_base;
mod fresnel;
mod fuzz;
mod gaussian_lobe;
mod ggx;
mod ggx_lobe;
mod lambert;
mod lights;
mod measured;
mod merl;
mod microfacet;
mod model;
mod models;
mod openpbr;
mod oren_nayar;
mod parameter;
mod parameters;
mod phong_lobe;
mod prelude;
mod sampled;
mod shared;
mod surface;
mod ward;
mod wgsl;
mod written;

pub use albedo::{Albedo, albedo_table};
pub use ashikhmin_shirley::AshikhminShirley;
pub use beckmann::Beckmann;
pub use blinn_phong::{BlinnPhong, BlinnPhongParameters};
#[cfg(any(test, feature = "test-scenes"))]
pub use content::example_file;
pub use content::{BrdfFile, BrdfFileError, Content, ContentKind, FilePart};
pub use fresnel::Metal;
pub use ggx::{Ggx, GgxParameters};
pub use ggx_lobe::GgxLobe;
pub use lambert::{Lambert, LambertParameters};
pub use lights::{CosinesX8, LightsX8, LobeMomentsX8, SpreadX8};
pub use measured::{Level, MEASURED_SIZE, Measured, MeasuredError};
pub use merl::{MISSING, Merl, MerlParameters};
pub use microfacet::{MIN_ALPHA, widths};
pub use model::Model;
pub use models::{BrdfModel, BrdfVisitor, SurfaceBrdf};
pub use openpbr::{OpenPbr, OpenPbrParameters};
pub use oren_nayar::{OrenNayar, OrenNayarParameters};
pub use parameter::{MOST_NUMBERS, MapUse, Parameter, Value, Values};
pub use parameters::Parameters;
pub use sampled::SampledLobe;
pub use shared::GlossyParameters;
pub use surface::SurfaceParameters;
pub use ward::{Ward, WardDuer};
pub use wgsl::{WIDE_LIGHT, Wgsl};
pub use written::{SIGNATURE, Written, WrittenError};

use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use wide::f32x8;

/// Widths of a model's lobes around the mirror direction, as microfacet `alpha` along the tangent and the bitangent.
pub type Lobes = [[f32; 2]; 3];

/// Widths of an absent lobe.
pub const NO_LOBE: [f32; 2] = [0.0; 2];

/// The narrower width of each lobe; 0 for none.
pub fn narrow_widths(lobes: Lobes) -> [f32; 3] {
    lobes.map(|[along, across]| along.min(across))
}

/// A reflectance model with its parameters.
pub trait Brdf {
    /// `f_r(wi, wo) cos θi` per color for eight lights.
    ///
    /// The spread of a light widens the lobe: the value is then close to the mean over the light's directions. The
    /// cosine belongs to the diffuse part.
    ///
    /// Generic over the lanes of an instruction set, for a [`Kernel`](crate::simd::Kernel), and therefore always inlined.
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L>
    where
        Self: Sized;

    /// [`Self::reflect`] for lights at the directions `wi`, with their cosines; zero below the horizon. A spread of zero
    /// gives the BRDF itself.
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8;

    /// Its lobes, which set how finely light directions around the mirror direction must be resolved.
    fn lobes(&self) -> Lobes;

    /// Width of the narrowest lobe, if there is one.
    fn narrowest_lobe(&self) -> Option<f32> {
        narrow_widths(self.lobes()).into_iter().filter(|&width| width > 0.0).reduce(f32::min)
    }

    /// Albedo for light from the normal: the share that a bounce reflects.
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

#[cfg(test)]
mod tests;
