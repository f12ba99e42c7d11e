//! Lights that are wholly visible or hidden at a point, found for eight adjacent points at once.

use super::DirectShader;
use crate::shade::surface::SurfacePoint;
use glam::Vec3;
use lapidary_core::{
    lights::{Disc, LightSampler},
    offset,
    ray::{EightCones, EightRays, SeenThrough},
};
use std::array::from_fn;

/// Known visibility of lights at a point, one bit for each of the first 64. Other lights need rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LightsSeen {
    whole: u64,
    none: u64,
}

impl LightsSeen {
    /// Whether a light is wholly visible (`true`) or hidden (`false`); `None` if unknown.
    pub fn of(self, light: usize) -> Option<bool> {
        let has = |bits: u64| light < 64 && bits >> light & 1 == 1;
        if has(self.whole) { Some(true) } else { has(self.none).then_some(false) }
    }
}

/// Above this number of lights without extent, only those that are bright at a point cast rays.
const MOST_DELTA: usize = 8;

/// Adjacent points; fewer at the end of a row.
pub(crate) type EightPoints<'p> = [Option<&'p SurfacePoint>; 8];

impl DirectShader<'_> {
    /// Whether visibility can be known before casting rays.
    pub fn may_know(&self) -> bool {
        self.lights.iter().any(|light| light.disc().is_some()) || (1..=MOST_DELTA).contains(&self.delta())
    }

    /// Number of lights without extent.
    fn delta(&self) -> usize {
        self.lights.iter().filter(|light| light.light().is_delta()).count()
    }

    /// Known visibility of lights at eight points; faster the closer the points are. Always unknown for rectangles.
    pub fn lights_seen(&self, points: &EightPoints) -> [LightsSeen; 8] {
        let mut seen = [LightsSeen::default(); 8];
        if points.iter().all(Option::is_none) {
            return seen;
        }
        let delta = self.delta();
        for (light, sampler) in self.lights.iter().enumerate().take(64) {
            let through = match sampler.disc() {
                Some(disc) => self.disc_seen(disc, points),
                None if sampler.light().is_delta() && delta <= MOST_DELTA => self.delta_seen(sampler, points),
                None => SeenThrough::default(),
            };
            for (i, seen) in seen.iter_mut().enumerate() {
                seen.whole |= u64::from(through.open >> i & 1) << light;
                seen.none |= u64::from(through.closed >> i & 1) << light;
            }
        }
        seen
    }

    /// Visibility of a disc, by cones.
    fn disc_seen(&self, disc: &Disc, points: &EightPoints) -> SeenThrough {
        let active = bits(|i| points[i].is_some_and(|point| point.may_receive(disc)));
        let origins = from_fn(|i| points[i].map_or(Vec3::ZERO, |point| point.ray_origin));
        self.intersector.seen_through(&EightCones { origins, axis: disc.axis, sine: disc.sine(), active })
    }

    /// Visibility of a light without extent, by rays.
    fn delta_seen(&self, light: &LightSampler, points: &EightPoints) -> SeenThrough {
        let rays = points.map(|point| {
            let point = point?;
            let sample = light.sample(point.ray_origin, Default::default())?;
            point.receives(sample.direction).then_some((point.ray_origin, sample))
        });
        let active = bits(|i| rays[i].is_some());
        let origins = rays.map(|ray| ray.map_or(Vec3::ZERO, |(origin, _)| origin));
        let directions = rays.map(|ray| ray.map_or(Vec3::Y, |(_, sample)| sample.direction));
        let before = rays.map(|ray| ray.map_or(0.0, |(_, sample)| offset::REACH_OF_SHADING * sample.distance));
        self.intersector.seen_before(&EightRays::new(origins, directions, active), before)
    }
}

fn bits(is_set: impl Fn(usize) -> bool) -> u8 {
    (0..8).map(|i| u8::from(is_set(i)) << i).sum()
}
