//! Suns that a point is known to see wholly or not at all, so that it casts no rays to them.

use super::DirectShader;
use crate::shade::surface::SurfacePoint;
use lapidary_core::ray::EightCones;
use std::array::from_fn;

/// What a point is known to see of lights, one bit for each of the first 64. Of others rays tell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SunsSeen {
    whole: u64,
    none: u64,
}

impl SunsSeen {
    /// Whether a light is seen wholly, or else not at all, if that is known.
    pub fn of(self, light: usize) -> Option<bool> {
        let has = |bits: u64| light < 64 && bits >> light & 1 == 1;
        if has(self.whole) { Some(true) } else { has(self.none).then_some(false) }
    }
}

impl DirectShader<'_> {
    /// What eight points are known to see of the suns among the lights; the nearer the points, the faster it is.
    pub fn suns_seen(&self, points: &[Option<&SurfacePoint>; 8]) -> [SunsSeen; 8] {
        let mut seen = [SunsSeen::default(); 8];
        for (light, disc) in self.lights.iter().enumerate().take(64).filter_map(|(i, light)| Some((i, light.disc()?))) {
            let faces = |point: &SurfacePoint| point.horizons().iter().all(|&normal| disc.may_be_above(normal));
            let active = (0..8).map(|i| u8::from(points[i].is_some_and(faces)) << i).sum();
            let origins = from_fn(|i| points[i].map_or(disc.axis, |point| point.ray_origin));
            let through =
                self.intersector.seen_through(&EightCones { origins, axis: disc.axis, sine: disc.sine(), active });
            for (i, seen) in seen.iter_mut().enumerate() {
                seen.whole |= u64::from(through.open >> i & 1) << light;
                seen.none |= u64::from(through.closed >> i & 1) << light;
            }
        }
        seen
    }
}
