//! The diffuse base of layered models (Kelemen and Szirmay-Kalos 2001).

use super::{Albedo, LightsX8};
use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// A diffuse base below a dielectric. It reflects the light that the dielectric leaves.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseBase {
    albedo: Vec3,
    above: Albedo,
}

impl DiffuseBase {
    /// A base of `albedo` below a layer of albedo `above`.
    #[inline]
    pub fn new(albedo: Vec3, above: Albedo) -> Self {
        Self { albedo, above }
    }

    /// The BRDF times the cosine.
    #[inline(always)]
    pub fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let left = self.above.left(lights.wi.z, L::splat(wo.z));
        Vec3x8::splat(self.albedo * (FRAC_1_PI * self.above.normalization())) * (left * lights.cosine)
    }

    /// Albedo for light from a direction with this cosine.
    pub fn albedo_at(&self, cosine: f32) -> Vec3 {
        self.albedo * (1.0 - self.above.at_one(cosine))
    }

    /// Albedo without the layer above.
    pub fn own_albedo(&self) -> Vec3 {
        self.albedo
    }
}
