//! Lobe width, albedo and sampling distribution of a BRDF known only by its values, for the traversal of cuts and the
//! path reference.
//!
//! The lobe is searched around the mirror direction, in the plane of incidence along the tangent and across it. Its
//! width is the width of the GGX lobe with the same half-height angle. Lobes elsewhere are not found: they are sampled
//! by the cosine, and nodes there are not refined.

use super::{Lobes, MIN_ALPHA, NO_LOBE};
use crate::{color::luminance, sphere::cosine_direction};
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

/// Angles of the half vector in a profile: squares over a right angle.
const STEPS: usize = 128;
/// Angles between light and half vector at which profiles are taken, in degrees.
const DIFFERENCES: [f32; 2] = [10.0, 40.0];
/// A peak below this share of the rest is no lobe.
const NEGLIGIBLE: f32 = 0.05;
/// Tangent of the half-height angle of a GGX lobe of width 1.
const HALF_TANGENT: f32 = 0.643_594_3;
/// Cosines in the table of albedos.
const ANGLES: usize = 16;
/// Directions per cosine.
const SAMPLES: usize = 512;
/// Smallest and largest probability of sampling the lobe.
const SHARES: [f32; 2] = [0.1, 0.9];

/// A lobe around the mirror direction over a wide rest, found by evaluation.
#[derive(Clone, Debug)]
pub struct SampledLobe {
    /// Width; 0 for none.
    width: f32,
    /// Probability of sampling the lobe instead of the cosine.
    share: f32,
    /// Cumulative probabilities of the bins of the half vector's angle.
    cumulated: [f32; STEPS],
    /// Albedos for cosines 1 / ANGLES to 1.
    albedo: [Vec3; ANGLES],
}

impl SampledLobe {
    /// Estimates the lobe of BRDF values for two directions, without cosine.
    pub fn of(value: &dyn Fn(Vec3, Vec3) -> Vec3) -> Self {
        let profiles = DIFFERENCES.map(|degrees| [Vec3::Y, Vec3::X].map(|axis| profile(value, axis, degrees)));
        let found = profiles.as_flattened();
        let width = found.iter().filter_map(Profile::width).reduce(f32::min).unwrap_or(0.0);
        let mut lobe = Self { width, share: 0.0, cumulated: cumulated(found), albedo: [Vec3::ZERO; ANGLES] };
        if width > 0.0 {
            lobe.share = 0.5;
            let all = luminance(lobe.integrated(value, cosine(ANGLES - 1))).max(1e-6);
            let rest = found.iter().map(|p| p.rest).sum::<f32>() / found.len() as f32;
            lobe.share = (1.0 - PI * rest / all).clamp(SHARES[0], SHARES[1]);
        }
        lobe.albedo = std::array::from_fn(|i| lobe.integrated(value, cosine(i)));
        lobe
    }

    /// Width of the lobe, 0 for none.
    pub fn width(&self) -> f32 {
        self.width
    }

    /// The lobe, as wide along the tangent as across it.
    pub fn lobes(&self) -> Lobes {
        let lobe = if self.width > 0.0 { [self.width; 2] } else { NO_LOBE };
        [lobe, NO_LOBE, NO_LOBE]
    }

    /// Albedo for light from a direction with this cosine.
    pub fn albedo_at(&self, cosine: f32) -> Vec3 {
        let place = (cosine * ANGLES as f32 - 1.0).clamp(0.0, (ANGLES - 1) as f32);
        let low = (place as usize).min(ANGLES - 2);
        self.albedo[low].lerp(self.albedo[low + 1], place - low as f32)
    }

    /// The largest component of all albedos; above 1 the BRDF gains energy.
    pub fn most_albedo(&self) -> f32 {
        self.albedo.iter().map(|albedo| albedo.max_element()).fold(0.0, f32::max)
    }

    /// A light direction, from three numbers in [0, 1).
    pub fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        if u.z < self.share { self.mirrored(wo, u.x, u.y) } else { cosine_direction(u.x, u.y) }
    }

    /// Density of [`Self::sample`] per solid angle.
    pub fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let h = (wi + wo).normalize_or(Vec3::Z);
        // The sampled half vector may be the opposite one.
        let bin = bin_of(h.z.abs());
        let probability = self.cumulated[bin] - if bin > 0 { self.cumulated[bin - 1] } else { 0.0 };
        let density = probability / (TAU * (cos_of(bin) - cos_of(bin + 1)));
        let lobe = density / (4.0 * wo.dot(h).abs().max(1e-6));
        self.share * lobe + (1.0 - self.share) * wi.z.max(0.0) * FRAC_1_PI
    }

    /// The eye's direction mirrored at a half vector of the distribution.
    fn mirrored(&self, wo: Vec3, u: f32, v: f32) -> Vec3 {
        let bin = self.cumulated.partition_point(|&cumulated| cumulated <= u).min(STEPS - 1);
        let before = if bin > 0 { self.cumulated[bin - 1] } else { 0.0 };
        let inside = ((u - before) / (self.cumulated[bin] - before).max(1e-9)).clamp(0.0, 1.0);
        let cos = cos_of(bin) + inside * (cos_of(bin + 1) - cos_of(bin));
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (y, x) = (TAU * v).sin_cos();
        let h = Vec3::new(sin * x, sin * y, cos);
        2.0 * wo.dot(h) * h - wo
    }

    /// The albedo for one cosine, by sampling.
    fn integrated(&self, value: &dyn Fn(Vec3, Vec3) -> Vec3, cosine: f32) -> Vec3 {
        let wo = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
        let weighed = |i: usize| {
            let wi = self.sample(wo, sequence(i));
            let density = self.pdf(wi, wo);
            if wi.z > 0.0 && density > 0.0 { value(wi, wo) * (wi.z / density) } else { Vec3::ZERO }
        };
        (0..SAMPLES).map(weighed).sum::<Vec3>() / SAMPLES as f32
    }
}

fn cosine(index: usize) -> f32 {
    (index + 1) as f32 / ANGLES as f32
}

/// Uniform sequence of points in the unit cube (Roberts 2018).
fn sequence(i: usize) -> Vec3 {
    let steps = Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);
    (0.5 + (i + 1) as f32 * steps).fract()
}

/// Angle of the half vector at which a bin begins.
fn angle_of(bin: usize) -> f32 {
    let part = bin as f32 / STEPS as f32;
    FRAC_PI_2 * part * part
}

fn cos_of(bin: usize) -> f32 {
    angle_of(bin).cos()
}

fn bin_of(cos: f32) -> usize {
    let bin = ((cos.min(1.0).acos() / FRAC_PI_2).sqrt() * STEPS as f32) as usize;
    bin.min(STEPS - 1)
}

/// Luminance of a BRDF against the angle of the half vector, in a plane of incidence.
struct Profile {
    values: [f32; STEPS],
    /// The minimum, which is not part of the lobe.
    rest: f32,
}

/// The profile in the plane across an axis, with light and eye `degrees` from the half vector. Zero below the horizon.
fn profile(value: &dyn Fn(Vec3, Vec3) -> Vec3, axis: Vec3, degrees: f32) -> Profile {
    let at = |bin: usize| {
        let h = 0.5 * (angle_of(bin) + angle_of(bin + 1));
        let [wi, wo] = [1.0, -1.0].map(|side| Quat::from_axis_angle(axis, h + side * degrees.to_radians()) * Vec3::Z);
        (wi.z > 0.0 && wo.z > 0.0).then(|| luminance(value(wi, wo)).max(0.0))
    };
    let seen = (0..STEPS).map_while(at).collect::<Vec<f32>>();
    let rest = seen.iter().copied().reduce(f32::min).unwrap_or(0.0);
    Profile { values: std::array::from_fn(|i| seen.get(i).copied().unwrap_or(rest)), rest }
}

impl Profile {
    /// Width of the lobe; none without a peak at the mirror direction.
    fn width(&self) -> Option<f32> {
        let peak = self.values[0] - self.rest;
        if !(peak > NEGLIGIBLE * self.rest) || peak <= 0.0 {
            return None;
        }
        let half = self.values.iter().position(|x| x - self.rest < 0.5 * peak)?;
        let tangent = angle_of(half).min(1.5).tan();
        Some((tangent / HALF_TANGENT).clamp(MIN_ALPHA, 1.0))
    }
}

/// The distribution of half vectors that follows the peaks of profiles.
fn cumulated(profiles: &[Profile]) -> [f32; STEPS] {
    let mut sum = 0.0;
    let mut cumulated = std::array::from_fn(|bin| {
        let (low, high) = (cos_of(bin), cos_of(bin + 1));
        let peak: f32 = profiles.iter().map(|p| p.values[bin] - p.rest).sum();
        sum += peak * 0.5 * (low + high) * (low - high);
        sum
    });
    if sum > 0.0 {
        cumulated.iter_mut().for_each(|x| *x /= sum);
    }
    cumulated[STEPS - 1] = 1.0;
    cumulated
}
