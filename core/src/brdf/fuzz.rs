//! Fuzz: upright fibers that scatter at grazing angles (Estevez and Kulla 2017, *Production Friendly Microfacet Sheen
//! BRDF*), with the smooth visibility of Neubelt and Pettineo 2013.

use super::LightsX8;
use crate::simd::Lanes;
use glam::Vec3;
use std::f32::consts::TAU;

use super::microfacet::HalfVectors;

/// Smallest roughness: narrower lobes reflect more than they receive.
pub const LEAST_ROUGHNESS: f32 = 0.2;

/// `D V` times the cosine, for fuzz of albedo near one at the horizon.
#[inline(always)]
pub fn reflect<L: Lanes>(roughness: f32, lights: &LightsX8<L>, half: &HalfVectors<L>, wo: Vec3) -> L {
    let inverse = 1.0 / roughness.max(LEAST_ROUGHNESS);
    let sin_sq = (L::splat(1.0) - half.cos_sq()).at_least(1e-7);
    let d = (sin_sq.ln() * L::splat(0.5 * inverse)).exp() * L::splat((2.0 + inverse) / TAU);
    let (cos_i, cos_o) = (lights.wi.z.at_least(0.0), L::splat(wo.z.max(1e-4)));
    let v = L::splat(0.25) / (cos_i + cos_o - cos_i * cos_o).at_least(1e-4);
    d * v * lights.cosine
}

/// The BRDF for one direction.
pub fn value(roughness: f32, wi: Vec3, wo: Vec3) -> f32 {
    let inverse = 1.0 / roughness.max(LEAST_ROUGHNESS);
    let h = (wi + wo).normalize_or(Vec3::Z);
    let sin_sq = (1.0 - h.z * h.z).max(1e-7);
    let d = sin_sq.powf(0.5 * inverse) * (2.0 + inverse) / TAU;
    d * 0.25 / (wi.z + wo.z - wi.z * wo.z).max(1e-4)
}
