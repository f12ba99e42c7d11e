//! The planes of an unfinished picture, to which samples are added row by row.

use crate::{
    backend::PictureStats,
    cpu::{display::display_pixel, sketch::Filled},
    light::direct::pixel_shift,
    post::Post,
    shade::{
        merge::Work,
        painter::Painter,
        pixel_sampler::{PixelSampler, Sight},
        surface::FirstHit,
        wireframe,
    },
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::Vec3;
use lapidary_core::image::Image;
use rayon::prelude::*;
use std::ops::Range;

/// Sums over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pixel {
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
    mode: ViewMode,
    pixels: Vec<Pixel>,
    /// Stand-ins for pixels without a sample; empty but for a sketch.
    filled: Vec<Filled>,
    work: Work,
}

impl Picture {
    pub fn new(view: &View) -> Self {
        let pixels = vec![Pixel::default(); view.size[0] as usize * view.size[1] as usize];
        Self { size: view.size, mode: view.mode, pixels, filled: Vec::new(), work: Work::default() }
    }

    /// Adds a sample to those pixels of some rows that have all samples before it and not this one. Each thread has a
    /// painter of its own.
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
            for (x, pixel) in pixels.iter_mut().enumerate().filter(|(_, pixel)| pixel.samples == sample as f32) {
                let [x, y] = [x as u32, first + row as u32];
                pixel.add(sampler, painter, [x, y], sample, sampler.sight(x, y, sample as usize));
            }
            painter.take_work()
        };
        let rows = band.par_chunks_mut(width.max(1)).enumerate().map_init(painter, paint_row);
        self.work += rows.reduce(Work::default, |a, b| a + b);
    }

    /// Whether a pixel has any sample.
    pub fn has_samples(&self, x: u32, y: u32) -> bool {
        self.pixels[y as usize * self.size[0] as usize + x as usize].samples > 0.0
    }

    /// The mean over a pixel's samples; `None` beyond the picture and without a sample.
    pub fn mean_at(&self, x: u32, y: u32) -> Option<Vec3> {
        if x >= self.size[0] || y >= self.size[1] {
            return None;
        }
        let pixel = &self.pixels[y as usize * self.size[0] as usize + x as usize];
        (pixel.samples > 0.0).then(|| pixel.value / pixel.samples)
    }

    /// Whether the pixels show radiance.
    pub fn is_lit(&self) -> bool {
        self.mode == ViewMode::Shaded
    }

    /// Sets pixels that had no sample, and counts the work for them.
    pub(super) fn set_pixels(&mut self, pixels: &[([u32; 2], Pixel)], work: Work) {
        for ([x, y], pixel) in pixels {
            self.pixels[*y as usize * self.size[0] as usize + *x as usize] = *pixel;
        }
        self.work += work;
    }

    /// Sets what pixels without a sample show.
    pub fn set_filled(&mut self, filled: Vec<Filled>) {
        self.filled = filled;
    }

    /// A pixel, or what fills it.
    fn shown(&self, i: usize) -> Pixel {
        let pixel = self.pixels[i];
        self.filled.get(i).filter(|_| pixel.samples == 0.0).map_or(pixel, Pixel::from)
    }

    /// Means over the samples, and the covered share of each pixel.
    pub fn read(&self) -> (Image, Vec<f32>) {
        let mean = |i: usize| {
            let p = self.shown(i);
            (p.value / p.samples.max(1.0), p.covered / p.samples.max(1.0))
        };
        let (pixels, coverage) = (0..self.pixels.len()).map(mean).unzip();
        (Image { size: self.size, pixels }, coverage)
    }

    /// Display colours of a picture of `view`; `count_top` as in [`display_pixel`].
    pub fn display(&self, view: &View, post: &Post, count_top: f32) -> Vec<[u8; 4]> {
        (0..self.pixels.len()).into_par_iter().map(|i| self.shown(i).display(view, post, count_top)).collect()
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

impl From<&Filled> for Pixel {
    fn from(filled: &Filled) -> Self {
        Self { value: filled.value, covered: 1.0, wire: filled.wire, samples: 1.0 }
    }
}

impl Pixel {
    /// With the first sample.
    pub fn first(sampler: &PixelSampler, painter: &mut Painter, pixel: [u32; 2], sight: Sight) -> Self {
        let mut first = Self::default();
        first.add(sampler, painter, pixel, 0, sight);
        first
    }

    fn add(&mut self, sampler: &PixelSampler, painter: &mut Painter, [x, y]: [u32; 2], sample: u32, sight: Sight) {
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
                    self.wire += sampler.wire(sight.position, point.corners);
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
