//! The planes of an unfinished picture, to which samples are added row by row.

use crate::{
    backend::PictureStats,
    cpu::display::display_pixel,
    light::direct::pixel_shift,
    post::Post,
    shade::{merge::Work, painter::Painter, pixel_sampler::PixelSampler, surface::FirstHit, wireframe},
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::Vec3;
use lapidary_core::image::Image;
use rayon::prelude::*;
use std::ops::Range;

/// Sums over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    value: Vec3,
    /// Samples that met a surface.
    covered: f32,
    /// Coverage by the lines of a wireframe.
    wire: f32,
    /// Counted per pixel, so that a picture is right between two bands of rows too.
    samples: f32,
}

/// A picture in the making.
pub(crate) struct Picture {
    size: [u32; 2],
    pixels: Vec<Pixel>,
    work: Work,
}

impl Picture {
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, pixels: vec![Pixel::default(); size[0] as usize * size[1] as usize], work: Work::default() }
    }

    /// Adds one sample to each pixel of some rows. Each thread has a painter of its own.
    pub fn add_rows<'a>(
        &mut self,
        sampler: &PixelSampler<'a>,
        painter: impl Fn() -> Painter<'a> + Sync + Send,
        sample: u32,
        rows: Range<u32>,
    ) {
        let width = self.size[0] as usize;
        let end = rows.end.min(self.size[1]);
        let first = rows.start.min(end);
        let band = &mut self.pixels[first as usize * width..end as usize * width];
        let paint_row = |painter: &mut Painter<'a>, (row, pixels): (usize, &mut [Pixel])| {
            for (x, pixel) in pixels.iter_mut().enumerate() {
                pixel.add(sampler, painter, [x as u32, first + row as u32], sample);
            }
            painter.take_work()
        };
        let rows = band.par_chunks_mut(width.max(1)).enumerate().map_init(painter, paint_row);
        self.work += rows.reduce(Work::default, |a, b| a + b);
    }

    /// Means over the samples, and the covered share of each pixel.
    pub fn read(&self) -> (Image, Vec<f32>) {
        let pixels = self.pixels.iter().map(|p| p.value / p.samples.max(1.0)).collect();
        let coverage = self.pixels.iter().map(|p| p.covered / p.samples.max(1.0)).collect();
        (Image { size: self.size, pixels }, coverage)
    }

    /// Display colours of a picture of `view`; `count_top` as in [`display_pixel`].
    pub fn display(&self, view: &View, post: &Post, count_top: f32) -> Vec<[u8; 4]> {
        self.pixels.par_iter().map(|p| p.display(view, post, count_top)).collect()
    }

    pub fn stats(&self) -> PictureStats {
        let points = self.work.points;
        let mean = |sum: u64| sum as f64 / points.max(1) as f64;
        PictureStats {
            pixels_shaded: points,
            mean_merged_nodes: mean(self.work.merged_nodes),
            mean_brdf_evaluations: mean(self.work.brdf_evaluations),
        }
    }
}

impl Pixel {
    fn add(&mut self, sampler: &PixelSampler, painter: &mut Painter, [x, y]: [u32; 2], sample: u32) {
        let sight = sampler.sight(x, y, sample as usize);
        self.samples += 1.0;
        match sight.seen {
            // The other modes show surfaces only: an environment is no count.
            FirstHit::Background if sampler.view.mode == ViewMode::Shaded => {
                self.value += sampler.behind(sight.direction)
            }
            FirstHit::Background => {}
            FirstHit::Back => self.covered += 1.0,
            FirstHit::Surface(point) => {
                self.value += painter.value(&point, pixel_shift(x, y, sample));
                self.covered += 1.0;
                if sampler.view.wireframe {
                    self.wire += sampler.wire(sight.position, &point);
                }
            }
        }
    }

    fn display(&self, view: &View, post: &Post, count_top: f32) -> [u8; 4] {
        // The background must not show where the picture has no coverage, so the mean is over the covered samples.
        let transparent = view.background == Background::Transparent;
        let weight = if transparent { self.covered } else { self.samples };
        if !(weight > 0.0) {
            return if transparent { [0; 4] } else { [0, 0, 0, 255] };
        }
        let alpha = if transparent { self.covered / self.samples } else { 1.0 };
        let shown = display_pixel(view.mode, post, count_top, self.value / weight);
        let [r, g, b] = wireframe::over(shown, self.wire / weight).to_array();
        [r, g, b, alpha].map(|v| (255.0 * v + 0.5) as u8)
    }
}
