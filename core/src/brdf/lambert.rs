//! Ideal diffuse reflection: `f = albedo / π`.

use super::{Brdf, LobeWidth};
use crate::{
    simd::{Lanes, Vec3x8},
    sphere::cosine_direction,
};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;
use wide::f32x8;

/// Ideal diffuse reflection.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    albedo: Vec3,
}

impl Lambert {
    /// `albedo` is linear, 0 to 1.
    pub fn new(albedo: Vec3) -> Self {
        Self { albedo }
    }
}

impl Brdf for Lambert {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.brdf_cos_lanes(wi, wo, inv_kappa)
    }

    #[inline(always)]
    fn brdf_cos_lanes<L: Lanes>(&self, wi: Vec3x8<L>, wo: Vec3, _inv_kappa: L) -> Vec3x8<L> {
        let facing = f32::from(u8::from(wo.z > 0.0));
        Vec3x8::splat(self.albedo * (FRAC_1_PI * facing)) * wi.z.at_least(0.0)
    }

    fn lobe(&self) -> Option<LobeWidth> {
        None
    }

    fn albedo(&self) -> Vec3 {
        self.albedo
    }

    fn sample(&self, _wo: Vec3, u: Vec3) -> Vec3 {
        cosine_direction(u.x, u.y)
    }

    fn pdf(&self, wi: Vec3, _wo: Vec3) -> f32 {
        wi.z.max(0.0) * FRAC_1_PI
    }
}
