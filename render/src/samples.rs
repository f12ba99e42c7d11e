//! Reference (a): all light samples, with visibility traced at the pixel. It isolates what the cuts lose: of the
//! environment, whose samples are directions, and of bounced light, whose samples are surface sources.
//!
//! Progressive in space: 16 passes over interleaved pixels, each pass exact where it has been.

pub(crate) mod distant;
pub(crate) mod sources;

use crate::{
    background::{Backdrop, BlurCache},
    frame::Frame,
    indirect::SourceLighting,
    renderer::{Illumination, Renderer},
    surface::SurfacePoint,
    view::{Progress, View},
};
use distant::LightSamples;
use glam::Vec3;
use lapidary_core::image::Image;
use rayon::prelude::*;
use sources::SourceSamples;

/// Pixels of a 4 x 4 block in the order of the passes: each pass halves the distance to the nearest one done.
const PASSES: [(u32, u32); 16] = [
    (0, 0),
    (2, 2),
    (2, 0),
    (0, 2),
    (1, 1),
    (3, 3),
    (3, 1),
    (1, 3),
    (1, 0),
    (3, 2),
    (3, 0),
    (1, 2),
    (0, 1),
    (2, 3),
    (2, 1),
    (0, 3),
];

/// Light of one surface point after another.
pub(crate) trait PointShader {
    /// Reflected radiance toward the eye.
    fn shade(&mut self, point: &SurfacePoint) -> Vec3;
}

impl Renderer {
    /// All light samples of the environment without cuts. If cancelled, pixels not reached repeat their block's first.
    pub fn samples_reference(&self, view: &View, light: &Illumination, progress: &dyn Progress) -> Image {
        let samples = LightSamples::of(&self.dataset.tree, &self.lighting(light, 1));
        let backdrop = Backdrop::new(view, light, &mut BlurCache::default());
        self.in_passes(&Frame::new(self, view, &backdrop), || samples.shader(self), progress)
    }

    /// The light of all surface sources without cuts, on black; cancelled as [`Self::samples_reference`].
    pub fn sources_reference(&self, view: &View, lighting: &SourceLighting, progress: &dyn Progress) -> Image {
        let samples = SourceSamples::new(self, lighting);
        let backdrop = Backdrop::black();
        self.in_passes(&Frame::new(self, view, &backdrop), || samples.shader(self), progress)
    }

    fn in_passes<S: PointShader>(
        &self,
        frame: &Frame,
        shader: impl Fn() -> S + Sync,
        progress: &dyn Progress,
    ) -> Image {
        let size = frame.view.size;
        let mut image = Image::filled(size, Vec3::ZERO);
        let total = u64::from(size[0]) * u64::from(size[1]);
        let mut done = 0;
        for (pass, &(dx, dy)) in PASSES.iter().enumerate() {
            let rows: Vec<u32> = (dy..size[1]).step_by(4).collect();
            // Some rows at a time, so that a large picture can be cancelled between them.
            for rows in rows.chunks(16) {
                if progress.cancelled() {
                    fill_blocks(&mut image, pass);
                    return image;
                }
                let shade = |y: &u32| -> Vec<Vec3> {
                    let mut shader = shader();
                    let mut pixel = |x| frame.pixel(x, *y, |point| shader.shade(point));
                    (dx..size[0]).step_by(4).map(&mut pixel).collect()
                };
                let shaded: Vec<Vec<Vec3>> = rows.par_iter().map(shade).collect();
                for (&y, row) in rows.iter().zip(shaded) {
                    for (i, value) in row.into_iter().enumerate() {
                        image.pixels[(y * size[0] + dx) as usize + 4 * i] = value;
                        done += 1;
                    }
                }
                progress.advanced(done, total);
            }
            progress.preview(&image);
        }
        image
    }
}

/// Gives pixels that no finished pass has reached the value of one in their block.
fn fill_blocks(image: &mut Image, finished: usize) {
    let [width, height] = image.size;
    for y in 0..height {
        for x in 0..width {
            let reached = PASSES[..finished].contains(&(x % 4, y % 4));
            if !reached && finished > 0 {
                image.pixels[(y * width + x) as usize] = image.at((x - x % 4) as usize, (y - y % 4) as usize);
            }
        }
    }
}
