//! The planes of an unfinished picture, to which samples are added row by row. Each part of the light has its own sum, so an edit
//! restarts only the parts and pixels that it changes; see [`crate::stale`].

mod filled;
mod row;
pub(crate) mod smoothed;

use crate::{
    backend::{PictureStats, ShadedSamples},
    cpu::display::display_pixel,
    post::{Post, vignetted},
    shade::direct::{pixel_shift, ray_shift},
    shade::{
        painter::{Painter, SeenOfParts},
        pixel_sampler::{PixelSampler, Sight},
        surface::FirstHit,
        wireframe,
    },
    stale::{LightPart, Marks, Pixels},
    view::{Background, View},
    view_mode::ViewMode,
};
pub(super) use filled::{Filled, FilledRow};
use glam::{Vec2, Vec3};
use lapidary_core::image::Image;
use rayon::prelude::*;
use row::Row;
use std::ops::Range;

/// Sample counts of one pixel, independent of its light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    marks: Marks,
    /// Counted per pixel, so a picture is also correct between two bands of rows.
    samples: u32,
    /// Samples that hit a surface, front or back.
    covered: u32,
    /// Samples that hit a surface to shade.
    surfaces: u32,
    /// Wireframe coverage.
    wire: f32,
}

/// Sum of one part of the light over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    value: Vec3,
    /// Share of the light that a ground transmits, in a picture with an alpha channel. [`Self::value`] includes it.
    through: f32,
    /// Sum of the widths of sharp lobes, for what mirrors show.
    width: f32,
    samples: u32,
    merged_nodes: u32,
    brdf_evaluations: u32,
}

/// An unfinished picture.
#[derive(Default)]
pub(crate) struct Picture {
    size: [u32; 2],
    seen: Vec<Seen>,
    /// Sums by [`LightPart`]; empty for parts that the light lacks.
    parts: [Vec<Sum>; LightPart::COUNT],
    /// Shaded surface samples by part, since the picture was started or resumed.
    shaded: [u64; LightPart::COUNT],
    /// Stand-ins for pixels that lack their first sample; empty but for a sketch.
    filled: Filled,
}

/// Missing parts of a pixel's first sample.
pub(super) struct FirstSample {
    pixel: [u32; 2],
    seen: Option<Seen>,
    /// Sums by [`LightPart`].
    sums: [Option<Sum>; LightPart::COUNT],
    shows_surface: bool,
}

impl Picture {
    /// Starts a picture without samples, for light with these parts. Reuses the buffers of `former`.
    pub fn new(size: [u32; 2], parts: [bool; LightPart::COUNT], former: Option<Self>) -> Self {
        let mut picture = former.unwrap_or_default();
        picture.size = size;
        picture.seen.clear();
        picture.seen.resize(size[0] as usize * size[1] as usize, Seen::default());
        picture.parts.iter_mut().for_each(Vec::clear);
        picture.resume(parts);
        picture
    }

    /// Allocates the parts of a light, drops others, and resets the counts.
    pub fn resume(&mut self, parts: [bool; LightPart::COUNT]) {
        for (sums, shown) in self.parts.iter_mut().zip(parts) {
            sums.resize(if shown { self.seen.len() } else { 0 }, Sum::default());
            if !shown {
                sums.shrink_to_fit();
            }
        }
        self.shaded = [0; LightPart::COUNT];
        self.filled.values.iter_mut().for_each(Vec::clear);
    }

    /// Drops the samples of a part in some pixels.
    pub fn forget(&mut self, part: LightPart, pixels: Pixels) {
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

    /// Adds the added lights' sums to the other lights; all pixels must have the same number of samples of both.
    pub fn merge_added(&mut self) {
        let [.., direct, added] = &mut self.parts;
        direct.par_iter_mut().zip(added.par_iter()).for_each(|(sum, added)| {
            sum.value += added.value;
            sum.through += added.through;
        });
    }

    /// Adds one sample to those pixels of some rows that lack it. Each thread has its own painter. `patches` are the vertices'
    /// patches, if pixels must know them.
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
        let sum = |a: [u64; LightPart::COUNT], b: [u64; LightPart::COUNT]| std::array::from_fn(|i| a[i] + b[i]);
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

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether the light has a part.
    pub(super) fn has_part(&self, part: LightPart) -> bool {
        !self.parts[part as usize].is_empty()
    }

    /// Parts of a pixel's light that lack their first sample.
    pub(super) fn lacks(&self, x: u32, y: u32) -> [bool; LightPart::COUNT] {
        let pixel = self.index(x, y);
        LightPart::ALL.map(|part| self.lacks_part(part, pixel))
    }

    fn lacks_part(&self, part: LightPart, pixel: usize) -> bool {
        self.parts[part as usize].get(pixel).is_some_and(|sum| sum.samples == 0)
    }

    fn lacks_any(&self, pixel: usize) -> bool {
        LightPart::ALL.into_iter().any(|part| self.lacks_part(part, pixel))
    }

    /// Mean of a part over a pixel's samples; `None` without samples and outside the picture.
    pub(super) fn value(&self, part: LightPart, x: u32, y: u32) -> Option<Vec3> {
        if x >= self.size[0] || y >= self.size[1] {
            return None;
        }
        let sum = self.parts[part as usize].get(self.index(x, y))?;
        (sum.samples > 0).then(|| sum.value / sum.samples as f32)
    }

    /// Whether all samples of a pixel see a surface of one material; otherwise the mean does not represent the light.
    pub(super) fn sees_one_surface(&self, x: u32, y: u32) -> bool {
        let Seen { marks, samples, surfaces, .. } = self.seen[self.index(x, y)];
        samples < 2 || (surfaces == samples && marks.materials.count_ones() == 1)
    }

    /// Displayed value of a part in a pixel: the mean over its samples, or its stand-in.
    pub(super) fn shown(&self, part: LightPart, x: u32, y: u32) -> Vec3 {
        self.shown_at(part, self.index(x, y))
    }

    fn shown_at(&self, part: LightPart, pixel: usize) -> Vec3 {
        match self.parts[part as usize].get(pixel) {
            None => Vec3::ZERO,
            Some(sum) if sum.samples > 0 => sum.value / sum.samples as f32,
            Some(_) => self.filled.values[part as usize].get(pixel).copied().unwrap_or_default(),
        }
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

    /// Buffers for stand-ins of all pixels, with their previous contents.
    pub(super) fn take_filled(&mut self, sampler: &PixelSampler) -> Filled {
        let mut filled = std::mem::take(&mut self.filled);
        for (values, sums) in filled.values.iter_mut().zip(&self.parts) {
            values.resize(sums.len(), Vec3::ZERO);
        }
        let room = |wanted| if wanted { self.seen.len() } else { 0 };
        filled.wire.resize(room(sampler.view.wireframe), 0.0);
        filled.through.resize(room(sampler.has_alpha_of_ground()), false);
        filled
    }

    /// Sets the stand-ins of pixels that lack their first sample.
    pub(super) fn set_filled(&mut self, filled: Filled) {
        self.filled = filled;
    }

    /// Whether all pixels that lack their first sample have stand-ins.
    pub(super) fn is_filled(&self) -> bool {
        !self.filled.values[LightPart::Environment as usize].is_empty()
    }

    /// Whether a pixel shows a stand-in.
    fn is_stand_in(&self, pixel: usize) -> bool {
        self.is_filled() && self.lacks_any(pixel)
    }

    /// Sum of all parts of a pixel as displayed, and its coverage.
    fn stand_in(&self, pixel: usize) -> (Vec3, f32) {
        let mirrored = self.shown_at(LightPart::Mirrors, pixel);
        let others = LightPart::ALL.into_iter().filter(|&part| part != LightPart::Mirrors);
        let shown = others.map(|part| self.shown_at(part, pixel)).sum::<Vec3>();
        match self.filled.through.get(pixel) {
            Some(true) => (Vec3::ZERO, (1.0 - shown.x).max(0.0)),
            _ => (shown + mirrored, 1.0),
        }
    }

    /// Means over the samples, and the covered share of each pixel.
    pub fn read(&self) -> (Image, Vec<f32>) {
        let pixel = |pixel| match self.is_stand_in(pixel) {
            true => self.stand_in(pixel),
            false => (self.mean(pixel), self.coverage(pixel)),
        };
        let (pixels, coverage) = (0..self.seen.len()).map(pixel).unzip();
        (Image { size: self.size, pixels }, coverage)
    }

    /// Mean over the samples of a pixel.
    fn mean(&self, pixel: usize) -> Vec3 {
        self.parts.iter().filter_map(|sums| sums.get(pixel)).map(Sum::shown).sum()
    }

    /// The same for the display of a picture that will have so many samples.
    fn mean_so_far(&self, pixel: usize, samples: u32) -> Vec3 {
        let others = LightPart::ALL.into_iter().filter(|&part| part != LightPart::Mirrors);
        let others = others.filter_map(|part| self.parts[part as usize].get(pixel)).map(Sum::shown).sum::<Vec3>();
        others + self.smoothed(pixel, samples)
    }

    /// Share of a pixel that hides the background.
    fn coverage(&self, pixel: usize) -> f32 {
        let through = |sum: &Sum| sum.through / sum.samples.max(1) as f32;
        let through: f32 = self.parts.iter().filter_map(|sums| sums.get(pixel)).map(through).sum();
        (self.seen[pixel].coverage() - through).max(0.0)
    }

    /// Display colors of a picture of `view`; `count_top` as in [`display_pixel`].
    pub fn display(&self, view: &View, post: &Post, count_top: f32) -> Vec<[u8; 4]> {
        (0..self.seen.len()).into_par_iter().map(|pixel| self.display_pixel(pixel, view, post, count_top)).collect()
    }

    /// Share of a pixel's light that the vignette leaves; quantities other than light have none.
    fn vignette(&self, pixel: usize, view: &View, post: &Post) -> f32 {
        let [width, _] = view.size.map(|side| side as usize);
        let place = [(pixel % width.max(1)) as u32, (pixel / width.max(1)) as u32];
        if view.mode.is_light() { vignetted(post.vignette, place, view.size) } else { 1.0 }
    }

    fn display_pixel(&self, pixel: usize, view: &View, post: &Post, count_top: f32) -> [u8; 4] {
        let transparent = view.background == Background::Transparent;
        let light = self.vignette(pixel, view, post);
        if self.is_stand_in(pixel) {
            let (value, alpha) = self.stand_in(pixel);
            let shown = display_pixel(view.mode, post, count_top, value * light);
            let wire = self.filled.wire.get(pixel).copied().unwrap_or_default();
            let [r, g, b] = wireframe::over(shown, wire).to_array();
            return [r, g, b, alpha].map(|v| (255.0 * v + 0.5) as u8);
        }
        let seen = &self.seen[pixel];
        if seen.samples == 0 {
            return if transparent { [0; 4] } else { [0, 0, 0, 255] };
        }
        let alpha = if transparent { self.coverage(pixel) } else { 1.0 };
        if alpha == 0.0 {
            return [0; 4];
        }
        // The background must not show where the picture has no coverage, so the mean is over covered samples.
        let shown = display_pixel(view.mode, post, count_top, light * self.mean_so_far(pixel, view.aa) / alpha);
        let [r, g, b] = wireframe::over(shown, seen.wire / (alpha * seen.samples as f32)).to_array();
        [r, g, b, alpha].map(|v| (255.0 * v + 0.5) as u8)
    }

    pub fn stats(&self) -> PictureStats {
        let points: u64 = self.seen.par_iter().map(|seen| u64::from(seen.surfaces)).sum();
        // Not that of points which mirrors show.
        let counted = LightPart::ALL.into_iter().filter(|&part| part != LightPart::Mirrors);
        let mean = |of: fn(&Sum) -> u32| {
            let parts = counted.clone().map(|part| &self.parts[part as usize]);
            let sums = parts.map(|sums| sums.par_iter().map(|sum| u64::from(of(sum))).sum::<u64>());
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

impl Sum {
    fn add(
        &mut self,
        part: LightPart,
        (sampler, painter): (&PixelSampler, &mut Painter),
        sight: &Sight,
        ([x, y, sample], seen_lights): ([u32; 3], SeenOfParts),
    ) {
        self.samples += 1;
        let shift = if part == LightPart::Mirrors { ray_shift } else { pixel_shift };
        match &sight.seen {
            // Other modes show surfaces only: an environment is not a count.
            FirstHit::Background if part == LightPart::Environment && sampler.view.mode == ViewMode::Shaded => {
                self.value += sampler.behind(sight.direction)
            }
            FirstHit::Background | FirstHit::Back => {}
            FirstHit::Surface(point) => {
                let shift = shift(x, y, sample);
                if part == LightPart::Mirrors {
                    self.width += painter.width_of_mirror(point);
                }
                if sampler.lets_light_through(point) {
                    let [reflected, caught] = match part {
                        LightPart::Mirrors => {
                            let [reflected, hidden] = painter.over_ground(point, shift);
                            [reflected, -hidden]
                        }
                        _ => [Vec3::ZERO, painter.part(part, point, shift, seen_lights)],
                    };
                    let share = sampler.share_let_through(caught);
                    self.through += share;
                    self.value += reflected + share;
                } else {
                    self.value += painter.part(part, point, shift, seen_lights);
                }
                let work = painter.take_work();
                self.merged_nodes += work.merged_nodes as u32;
                self.brdf_evaluations += work.brdf_evaluations as u32;
            }
        }
    }
}

impl FirstSample {
    /// Missing parts of a pixel's first sample along `sight`.
    pub fn new(
        picture: &Picture,
        (sampler, painter): (&PixelSampler, &mut Painter),
        patches: Option<&[u8]>,
        [x, y]: [u32; 2],
        (sight, seen_lights): (&Sight, SeenOfParts),
    ) -> Self {
        let lacks = picture.lacks(x, y);
        let seen = (picture.seen[picture.index(x, y)].samples == 0).then(|| {
            let mut seen = Seen::default();
            seen.add(sampler, sight.position, &sight.seen, patches);
            seen
        });
        let sums = LightPart::ALL.map(|part| {
            lacks[part as usize].then(|| {
                let mut sum = Sum::default();
                sum.add(part, (sampler, &mut *painter), sight, ([x, y, 0], seen_lights));
                sum
            })
        });
        Self { pixel: [x, y], seen, sums, shows_surface: matches!(sight.seen, FirstHit::Surface(_)) }
    }
}

/// Known visibility of the missing parts' lights, for the surfaces of up to eight sights.
pub(super) fn lights_seen(
    painter: &Painter,
    sights: &[Sight],
    lacks: impl Fn(usize) -> [bool; LightPart::COUNT],
) -> [SeenOfParts; 8] {
    painter.lights_seen(&std::array::from_fn(|i| sights.get(i).and_then(Sight::surface)), lacks)
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
