//! Reflections of a few samples, smoothed for the display: lobes that are wide for a mirror have one ray a sample. Twin of `smoothed`
//! in `shaders/display_pass.wgsl`.

use super::{Picture, Sum};
use crate::stale::LightPart;
use glam::Vec3;

/// Narrower lobes have no visible noise.
const LEAST_WIDTH: f32 = 0.01;
/// Pixels to each side.
const REACH: i64 = 2;
/// Largest ratio of widths of lobes in pixels that are smoothed together.
const MOST_RATIO: f32 = 1.1;

/// A test compares the shader's copies with these.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 2] = [("LEAST_WIDTH", LEAST_WIDTH), ("MOST_RATIO", MOST_RATIO)];

impl Picture {
    /// Mean of what mirrors show in a pixel, smoothed the more the fewer samples it has; with all `samples` not at all.
    pub(super) fn smoothed(&self, pixel: usize, samples: u32) -> Vec3 {
        let sums = &self.parts[LightPart::Mirrors as usize];
        let Some(own) = sums.get(pixel) else { return Vec3::ZERO };
        let width = own.width_of_lobe();
        if own.samples >= samples || !(width > LEAST_WIDTH) {
            return own.shown();
        }
        let [columns, rows] = self.size.map(i64::from);
        let [x, y] = [pixel as i64 % columns, pixel as i64 / columns];
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for y in (y - REACH).max(0)..=(y + REACH).min(rows - 1) {
            for x in (x - REACH).max(0)..=(x + REACH).min(columns - 1) {
                let other = &sums[(y * columns + x) as usize];
                let [narrow, wide] = [other.width_of_lobe().min(width), other.width_of_lobe().max(width)];
                if wide < MOST_RATIO * narrow {
                    sum += other.shown();
                    count += 1.0;
                }
            }
        }
        own.shown().lerp(sum / count, 1.0 / (own.samples.max(1) as f32).sqrt())
    }
}

impl Sum {
    /// Mean width of the samples' sharp lobes.
    fn width_of_lobe(&self) -> f32 {
        self.width / self.samples.max(1) as f32
    }

    /// Mean over the samples.
    pub(super) fn shown(&self) -> Vec3 {
        (self.value - self.through) / self.samples.max(1) as f32
    }
}
