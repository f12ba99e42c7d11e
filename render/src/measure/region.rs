//! Pictures of a region of a frame.

use crate::{
    shade::{pixel_sampler::PixelSampler, point_shader::PointShader},
    view::Progress,
};
use glam::Vec3;
use lapidary_core::image::{Image, Region};
use rayon::prelude::*;

/// Rows between checks for cancellation.
const BAND: usize = 8;

/// The region's part of a frame. Each thread has its own shader; `None` if cancelled.
pub(crate) fn picture_of<S: PointShader>(
    sampler: &PixelSampler,
    region: Region,
    shader: impl Fn() -> S + Sync,
    progress: &dyn Progress,
) -> Option<Image> {
    let rows: Vec<u32> = region.rows().collect();
    let mut pixels = Vec::with_capacity(region.pixels() as usize);
    for band in rows.chunks(BAND) {
        if progress.cancelled() {
            return None;
        }
        let row = |shader: &mut S, &y: &u32| -> Vec<Vec3> {
            region.columns().map(|x| sampler.pixel(x, y, |point| shader.shade(point))).collect()
        };
        let shaded: Vec<Vec<Vec3>> = band.par_iter().map_init(&shader, row).collect();
        pixels.extend(shaded.into_iter().flatten());
        progress.advanced(pixels.len() as u64, region.pixels());
    }
    Some(Image { size: region.size(), pixels })
}
