//! The planes of an unfinished picture, to which samples are added row by row. Each part of the light has a sum of its
//! own, so that an edit makes only those parts and pixels begin anew that it changes; see [`crate::stale`].

use crate::{
    backend::{PictureStats, ShadedSamples},
    cpu::{display::display_pixel, sketch::Filled},
    light::direct::pixel_shift,
    post::Post,
    shade::{
        painter::Painter,
        pixel_sampler::{PixelSampler, Sight},
        surface::FirstHit,
        wireframe,
    },
    stale::{Marks, Part, Pixels},
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::{Vec2, Vec3};
use lapidary_core::image::Image;
use rayon::prelude::*;
use std::ops::Range;

/// What the samples of one pixel show, whatever its light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    marks: Marks,
    /// Counted per pixel, so that a picture is right between two bands of rows too.
    samples: u32,
    /// Samples that met a surface, its back included.
    covered: u32,
    /// Samples that met a surface to shade.
    surfaces: u32,
    /// Coverage by the lines of a wireframe.
    wire: f32,
}

/// Sum of one part of the light over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    value: Vec3,
    samples: u32,
    /// Samples that met a surface, its back included.
    covered: u32,
    merged_nodes: u32,
    brdf_evaluations: u32,
}

/// A picture in the making.
pub(crate) struct Picture {
    size: [u32; 2],
    seen: Vec<Seen>,
    /// By [`Part`]; empty where the light has no such part.
    parts: [Vec<Sum>; Part::COUNT],
    /// Samples of surfaces that were shaded, by part, since the picture was begun or resumed.
    shaded: [u64; Part::COUNT],
    /// Stand-ins for pixels that lack their first sample; empty but for a sketch.
    filled: Vec<Filled>,
}

/// The first sample of a pixel, as far as the picture lacks it.
pub(super) struct FirstSample {
    pixel: [u32; 2],
    seen: Option<Seen>,
    /// By [`Part`].
    sums: [Option<Sum>; Part::COUNT],
    shows_surface: bool,
}

/// The parts of a pixel's light that lack their first sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lacking([bool; Part::COUNT]);

/// The pixels of a row.
struct Row<'p> {
    y: u32,
    seen: &'p mut [Seen],
    parts: [&'p mut [Sum]; Part::COUNT],
}

impl Picture {
    /// Without samples, of a light with these parts.
    pub fn new(size: [u32; 2], parts: [bool; Part::COUNT]) -> Self {
        let seen = vec![Seen::default(); size[0] as usize * size[1] as usize];
        let mut picture = Self { size, seen, parts: Default::default(), shaded: [0; Part::COUNT], filled: Vec::new() };
        picture.resume(parts);
        picture
    }

    /// Makes room for the parts of a light, drops the others, and begins to count.
    pub fn resume(&mut self, parts: [bool; Part::COUNT]) {
        for (sums, shown) in self.parts.iter_mut().zip(parts) {
            sums.resize(if shown { self.seen.len() } else { 0 }, Sum::default());
            sums.shrink_to_fit();
        }
        self.shaded = [0; Part::COUNT];
        self.filled.clear();
    }

    /// Drops the samples of a part in some pixels.
    pub fn forget(&mut self, part: Part, pixels: Pixels) {
        let sums = &mut self.parts[part as usize];
        match pixels {
            Pixels::Nothing => {}
            Pixels::All => sums.fill(Sum::default()),
            Pixels::Showing(_) => sums.par_iter_mut().zip(&self.seen).for_each(|(sum, seen)| {
                if pixels.contain(seen.marks) {
                    *sum = Sum::default();
                }
            }),
        }
    }

    /// Adds the added lights to the others; all pixels have as many samples of both.
    pub fn merge_added(&mut self) {
        let [.., direct, added] = &mut self.parts;
        direct.par_iter_mut().zip(added.par_iter()).for_each(|(sum, added)| sum.value += added.value);
    }

    /// Adds one sample to those pixels of some rows that lack it. Each thread has a painter of its own. `patches` are
    /// those of the vertices, where the pixels are to know them.
    pub fn add_rows<'a>(
        &mut self,
        sampler: &PixelSampler<'a>,
        painter: impl Fn() -> Painter<'a> + Sync + Send,
        patches: Option<&[u8]>,
        sample: u32,
        rows: Range<u32>,
    ) {
        let add_row = |painter: &mut Painter<'a>, row: Row| row.add(sampler, painter, patches, sample);
        let shaded = self.rows(rows).into_par_iter().map_init(painter, add_row);
        let sum = |a: [u64; Part::COUNT], b: [u64; Part::COUNT]| std::array::from_fn(|i| a[i] + b[i]);
        let shaded = shaded.reduce(Default::default, sum);
        self.shaded = sum(self.shaded, shaded);
    }

    fn rows(&mut self, rows: Range<u32>) -> Vec<Row<'_>> {
        let width = self.size[0].max(1) as usize;
        let mut parts = self.parts.each_mut().map(|sums| sums.chunks_mut(width));
        let rows_of_pixels = self.seen.chunks_mut(width).zip(0..).map(|(seen, y)| Row {
            y,
            seen,
            parts: parts.each_mut().map(|rows| rows.next().unwrap_or_default()),
        });
        rows_of_pixels.filter(|row| rows.contains(&row.y)).collect()
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.size[0] as usize + x as usize
    }

    /// What a pixel lacks of its first sample; `None` if it lacks nothing.
    pub(super) fn lacking(&self, x: u32, y: u32) -> Option<Lacking> {
        self.lacking_at(self.index(x, y))
    }

    fn lacking_at(&self, pixel: usize) -> Option<Lacking> {
        let lacks = Part::ALL.map(|part| self.parts[part as usize].get(pixel).is_some_and(|sum| sum.samples == 0));
        lacks.contains(&true).then_some(Lacking(lacks))
    }

    /// The mean over a pixel's samples of what another pixel lacks; `None` beyond the picture, and if it lacks any of
    /// that too.
    pub(super) fn mean_of(&self, x: u32, y: u32, lacking: Lacking) -> Option<Vec3> {
        if x >= self.size[0] || y >= self.size[1] {
            return None;
        }
        self.sum_of(self.index(x, y), |part| lacking.0[part as usize])
    }

    /// The mean over a pixel's samples of what it does not lack.
    pub(super) fn mean_of_rest(&self, x: u32, y: u32, lacking: Lacking) -> Vec3 {
        self.sum_of(self.index(x, y), |part| !lacking.0[part as usize]).unwrap_or_default()
    }

    fn sum_of(&self, pixel: usize, wanted: impl Fn(Part) -> bool) -> Option<Vec3> {
        let mut sum = Vec3::ZERO;
        for part in Part::ALL.into_iter().filter(|&part| wanted(part)) {
            let Some(part) = self.parts[part as usize].get(pixel) else { continue };
            if part.samples == 0 {
                return None;
            }
            sum += part.value / part.samples as f32;
        }
        Some(sum)
    }

    /// Adds first samples, and counts them.
    pub(super) fn set_first(&mut self, samples: Vec<FirstSample>) {
        for FirstSample { pixel: [x, y], seen, sums, shows_surface } in samples {
            let pixel = self.index(x, y);
            if let Some(seen) = seen {
                self.seen[pixel] = seen;
            }
            for ((sums, sum), shaded) in self.parts.iter_mut().zip(sums).zip(&mut self.shaded) {
                let Some(sum) = sum else { continue };
                sums[pixel] = sum;
                *shaded += u64::from(shows_surface);
            }
        }
    }

    /// Sets what pixels show that lack their first sample.
    pub fn set_filled(&mut self, filled: Vec<Filled>) {
        self.filled = filled;
    }

    /// What stands in for a pixel.
    fn filled(&self, pixel: usize) -> Option<&Filled> {
        self.filled.get(pixel).filter(|_| self.lacking_at(pixel).is_some())
    }

    /// Means over the samples, and the covered share of each pixel.
    pub fn read(&self) -> (Image, Vec<f32>) {
        let mean = |pixel| self.filled(pixel).map_or_else(|| self.mean(pixel, false), |filled| filled.value);
        let pixels = (0..self.seen.len()).map(mean).collect();
        let covered = |pixel| if self.filled(pixel).is_some() { 1.0 } else { self.seen[pixel].coverage() };
        let coverage = (0..self.seen.len()).map(covered).collect();
        (Image { size: self.size, pixels }, coverage)
    }

    /// Mean over the samples of a pixel, or over those that met a surface.
    fn mean(&self, pixel: usize, covered: bool) -> Vec3 {
        let mean = |sum: &Sum| sum.value / (if covered { sum.covered } else { sum.samples }).max(1) as f32;
        self.parts.iter().filter_map(|sums| sums.get(pixel)).map(mean).sum()
    }

    /// Display colours of a picture of `view`; `count_top` as in [`display_pixel`].
    pub fn display(&self, view: &View, post: &Post, count_top: f32) -> Vec<[u8; 4]> {
        (0..self.seen.len()).into_par_iter().map(|pixel| self.display_pixel(pixel, view, post, count_top)).collect()
    }

    fn display_pixel(&self, pixel: usize, view: &View, post: &Post, count_top: f32) -> [u8; 4] {
        // The background must not show where the picture has no coverage, so the mean is over the covered samples.
        let transparent = view.background == Background::Transparent;
        if let Some(filled) = self.filled(pixel) {
            let [r, g, b] =
                wireframe::over(display_pixel(view.mode, post, count_top, filled.value), filled.wire).to_array();
            return [r, g, b, 1.0].map(|v| (255.0 * v + 0.5) as u8);
        }
        let seen = &self.seen[pixel];
        let weight = if transparent { seen.covered } else { seen.samples };
        if weight == 0 {
            return if transparent { [0; 4] } else { [0, 0, 0, 255] };
        }
        let alpha = if transparent { seen.coverage() } else { 1.0 };
        let shown = display_pixel(view.mode, post, count_top, self.mean(pixel, transparent));
        let [r, g, b] = wireframe::over(shown, seen.wire / weight as f32).to_array();
        [r, g, b, alpha].map(|v| (255.0 * v + 0.5) as u8)
    }

    pub fn stats(&self) -> PictureStats {
        let points: u64 = self.seen.par_iter().map(|seen| u64::from(seen.surfaces)).sum();
        let mean = |of: fn(&Sum) -> u32| {
            let sums = self.parts.iter().map(|sums| sums.par_iter().map(|sum| u64::from(of(sum))).sum::<u64>());
            sums.sum::<u64>() as f64 / points.max(1) as f64
        };
        PictureStats {
            pixels_shaded: points,
            mean_merged_nodes: mean(|sum| sum.merged_nodes),
            mean_brdf_evaluations: mean(|sum| sum.brdf_evaluations),
            shaded: ShadedSamples::of(self.shaded),
        }
    }
}

impl Row<'_> {
    /// Adds a sample to each pixel that lacks it. Returns the samples of surfaces that were shaded, by part.
    fn add(
        mut self,
        sampler: &PixelSampler,
        painter: &mut Painter,
        patches: Option<&[u8]>,
        sample: u32,
    ) -> [u64; Part::COUNT] {
        let mut shaded = [0; Part::COUNT];
        for x in 0..self.seen.len() {
            let lacks = Part::ALL.map(|part| self.parts[part as usize].get(x).is_some_and(|s| s.samples == sample));
            let surface = self.add_to_pixel(x, lacks, (sampler, painter), patches, sample);
            shaded.iter_mut().zip(lacks).for_each(|(count, lacks)| *count += u64::from(surface && lacks));
        }
        shaded
    }

    /// Adds a sample to those parts of a pixel that lack it. Returns whether it met a surface to shade.
    fn add_to_pixel(
        &mut self,
        x: usize,
        lacks: [bool; Part::COUNT],
        (sampler, painter): (&PixelSampler, &mut Painter),
        patches: Option<&[u8]>,
        sample: u32,
    ) -> bool {
        let seen = &mut self.seen[x];
        if !lacks.contains(&true) && seen.samples != sample {
            return false;
        }
        let sight = sampler.sight(x as u32, self.y, sample as usize);
        if seen.samples == sample {
            seen.add(sampler, sight.position, &sight.seen, patches);
        }
        let pixel = [x as u32, self.y];
        for part in Part::ALL.into_iter().filter(|&part| lacks[part as usize]) {
            self.parts[part as usize][x].add(part, (sampler, painter), &sight, pixel_shift(pixel[0], pixel[1], sample));
        }
        matches!(sight.seen, FirstHit::Surface(_))
    }
}

impl Sum {
    fn add(&mut self, part: Part, (sampler, painter): (&PixelSampler, &mut Painter), sight: &Sight, shift: Vec2) {
        self.samples += 1;
        self.covered += u32::from(!matches!(sight.seen, FirstHit::Background));
        match &sight.seen {
            // The other modes show surfaces only: an environment is no count.
            FirstHit::Background if part == Part::Environment && sampler.view.mode == ViewMode::Shaded => {
                self.value += sampler.behind(sight.direction)
            }
            FirstHit::Background | FirstHit::Back => {}
            FirstHit::Surface(point) => {
                self.value += painter.part(part, point, shift);
                let work = painter.take_work();
                self.merged_nodes += work.merged_nodes as u32;
                self.brdf_evaluations += work.brdf_evaluations as u32;
            }
        }
    }
}

impl FirstSample {
    /// What a pixel lacks of its first sample, with `sight`.
    pub fn new(
        picture: &Picture,
        (sampler, painter): (&PixelSampler, &mut Painter),
        patches: Option<&[u8]>,
        [x, y]: [u32; 2],
        sight: &Sight,
    ) -> Self {
        let lacks = picture.lacking(x, y).map_or([false; Part::COUNT], |lacking| lacking.0);
        let seen = (picture.seen[picture.index(x, y)].samples == 0).then(|| {
            let mut seen = Seen::default();
            seen.add(sampler, sight.position, &sight.seen, patches);
            seen
        });
        let sums = Part::ALL.map(|part| {
            lacks[part as usize].then(|| {
                let mut sum = Sum::default();
                sum.add(part, (sampler, &mut *painter), sight, pixel_shift(x, y, 0));
                sum
            })
        });
        Self { pixel: [x, y], seen, sums, shows_surface: matches!(sight.seen, FirstHit::Surface(_)) }
    }
}

impl Seen {
    fn add(&mut self, sampler: &PixelSampler, position: Vec2, hit: &FirstHit, patches: Option<&[u8]>) {
        self.samples += 1;
        self.covered += u32::from(!matches!(hit, FirstHit::Background));
        if let FirstHit::Surface(point) = hit {
            self.surfaces += 1;
            self.marks = self.marks.union(Marks::of_surface(point.material, point.vertices, patches));
            if sampler.view.wireframe {
                self.wire += sampler.wire(position, point.corners);
            }
        }
    }

    fn coverage(&self) -> f32 {
        self.covered as f32 / self.samples.max(1) as f32
    }
}
