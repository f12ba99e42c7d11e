//! The joint bilateral filter between lattice points. It fills each part of the light separately.

use super::{Sketch, history::Detail};
use crate::{
    cpu::picture::{Filled, FilledRow, Picture},
    shade::pixel_sampler::PixelSampler,
    sketch::{Guide, Mean, OTHER, around},
    stale::LightPart,
    view_mode::ViewMode,
};
use glam::{IVec2, Vec3};
use rayon::prelude::*;

/// Radius in pixels around a hole within which one shaded pixel stands in for several holes.
const BESIDE: i32 = 3;

/// A pixel that no neighbor fits.
pub(super) struct Hole {
    pub pixel: [u32; 2],
    /// Whether no nearby surface gives a guess.
    pub is_bare: bool,
}

/// A sketch and its picture with missing pixels.
pub(super) struct Filter<'a> {
    sketch: &'a Sketch,
    picture: &'a Picture,
    sampler: &'a PixelSampler<'a>,
    pixel_angle: f32,
}

/// Fitting lattice points around a pixel, with their weights.
struct Taps {
    cells: i32,
    points: [([u32; 2], f32); 16],
    count: usize,
}

impl<'a> Filter<'a> {
    pub fn new(sketch: &'a Sketch, picture: &'a Picture, sampler: &'a PixelSampler<'a>) -> Self {
        let pixel_angle = sampler.view.projection().pixel_span(1.0);
        Self { sketch, picture, sampler, pixel_angle }
    }

    /// Fills pixels without a sample and returns those that no neighbor fits.
    pub fn fill(&self, filled: &mut Filled) -> Vec<Hole> {
        filled.rows(self.sampler.view.size[0]).into_par_iter().flat_map_iter(|row| self.fill_row(row)).collect()
    }

    fn fill_row(&self, row: FilledRow) -> Vec<Hole> {
        let (mut holes, y) = (Vec::new(), row.y);
        for x in 0..self.sampler.view.size[0] {
            let lacks = self.picture.lacks(x, y);
            if !lacks.contains(&true) {
                continue;
            }
            let guide = self.sketch.guide(x, y);
            if let Some(wire) = row.wire.get_mut(x as usize) {
                *wire = self.sampler.first_wire(x, y, guide.triangle & !Guide::FROM_BEHIND);
            }
            if let Some(through) = row.through.get_mut(x as usize) {
                *through = self.sampler.is_of_ground(guide.material);
            }
            let (near, mut hole) = (self.taps([x, y], 1, |other, reach| guide.fit(other, reach)), None);
            for part in LightPart::ALL.into_iter().filter(|&part| lacks[part as usize]) {
                let fitting = self.fitting(part, [x, y], guide, &near);
                let value = fitting.or_else(|| {
                    let guess = self.guess(part, [x, y], guide);
                    hole = Some(Hole { pixel: [x, y], is_bare: guess.is_none() });
                    guess
                });
                row.values[part as usize][x as usize] = self.value(guide, value.unwrap_or_default());
            }
            holes.extend(hole);
        }
        holes
    }

    /// Displayed value of a pixel from the mean around it, in units of its divisor.
    fn value(&self, guide: &Guide, mean: Vec3) -> Vec3 {
        let shown = mean * self.divisor(guide);
        let is_share = self.sampler.has_alpha_of_ground() && self.sampler.is_of_ground(guide.material);
        if is_share { Vec3::splat(self.sampler.share_let_through(shown)) } else { shown }
    }

    /// Fills holes next to shaded holes: thin objects are shaded only in part.
    pub fn fill_beside(&self, holes: &[Hole], filled: &mut Filled) {
        let beside = |hole: &Hole| self.beside(hole.pixel);
        let values: Vec<_> = holes.par_iter().map(beside).collect();
        for (Hole { pixel: [x, y], .. }, values) in holes.iter().zip(values) {
            let pixel = (y * self.sampler.view.size[0] + x) as usize;
            for (part, value) in filled.values.iter_mut().zip(values) {
                value.into_iter().for_each(|value| part[pixel] = value);
            }
        }
    }

    fn beside(&self, [x, y]: [u32; 2]) -> [Option<Vec3>; LightPart::COUNT] {
        let (lacks, guide) = (self.picture.lacks(x, y), self.sketch.guide(x, y));
        let reach = self.reach(guide, BESIDE as u32);
        LightPart::ALL.map(|part| {
            let mut mean = Mean::default();
            for (other, weight) in around([x, y], 1, BESIDE).filter(|_| lacks[part as usize]) {
                self.add(part, &mut mean, other, weight, |other| guide.fit(other, reach));
            }
            mean.any().map(|mean| self.value(guide, mean))
        })
    }

    /// Mean of the lattice points around a pixel, or of the next ring, as far as they fit; else the last picture's value.
    fn fitting(&self, part: LightPart, pixel: [u32; 2], guide: &Guide, near: &Taps) -> Option<Vec3> {
        self.interpolated(part, pixel, near)
            .or_else(|| self.interpolated(part, pixel, &self.taps(pixel, 2, |other, reach| guide.fit(other, reach))))
            .or_else(|| self.predicted(part, pixel))
    }

    /// Mean over the nearest surfaces, with a strong preference for the same material.
    fn guess(&self, part: LightPart, pixel: [u32; 2], guide: &Guide) -> Option<Vec3> {
        let fit = |other: &Guide| if other.material == guide.material { 1.0 } else { OTHER };
        let mut mean = Mean::default();
        for (other, weight) in around(pixel, self.stride(pixel), 2) {
            self.add(part, &mut mean, other, weight, fit);
        }
        mean.any()
    }

    /// Adds a lattice point's radiance over albedo, if the picture has it.
    fn add(&self, part: LightPart, mean: &mut Mean, IVec2 { x, y }: IVec2, weight: f32, fit: impl Fn(&Guide) -> f32) {
        // Negative places are beyond any size.
        let Some(value) = self.picture.value(part, x as u32, y as u32) else { return };
        let other = self.sketch.guide(x as u32, y as u32);
        let weight = if other.is_lit() { weight * fit(other) } else { 0.0 };
        if weight > 0.0 {
            mean.add(value / self.divisor(other), weight);
        }
    }

    /// The fitting lattice points around a pixel.
    fn taps(&self, pixel: [u32; 2], cells: i32, fit: impl Fn(&Guide, f32) -> f32) -> Taps {
        let stride = self.stride(pixel);
        let reach = self.reach(self.sketch.guide(pixel[0], pixel[1]), stride);
        let [width, height] = self.sampler.view.size;
        let mut taps = Taps { cells, points: [([0; 2], 0.0); 16], count: 0 };
        for (IVec2 { x, y }, weight) in around(pixel, stride, cells) {
            let [x, y] = [x as u32, y as u32];
            if !(weight > 0.0) || x >= width || y >= height {
                continue;
            }
            let other = self.sketch.guide(x, y);
            let weight = if other.is_lit() { weight * fit(other, reach) } else { 0.0 };
            if weight > 0.0 {
                taps.points[taps.count] = ([x, y], weight);
                taps.count += 1;
            }
        }
        taps
    }

    /// Weighted mean of taps, with detail from the last picture, if enough of their weight fits.
    fn interpolated(&self, part: LightPart, pixel: [u32; 2], taps: &Taps) -> Option<Vec3> {
        let (mut mean, mut detail) = (Mean::default(), self.predicted(part, pixel).map(Detail::of));
        for &([x, y], weight) in &taps.points[..taps.count] {
            let Some(value) = self.picture.value(part, x, y) else { continue };
            let value = value / self.divisor(self.sketch.guide(x, y));
            mean.add(value, weight);
            if let Some((detail, before)) = detail.as_mut().zip(self.predicted(part, [x, y])) {
                detail.add(before, value, weight);
            }
        }
        let detail = detail.map_or(Vec3::ZERO, |detail| detail.trusted());
        mean.fitting(taps.cells).map(|mean| (mean + detail).max(Vec3::ZERO))
    }

    /// The last picture's value for a pixel.
    fn predicted(&self, part: LightPart, [x, y]: [u32; 2]) -> Option<Vec3> {
        self.sketch.history.as_ref()?.predicted(part, x, y)
    }

    /// Lattice spacing in meters at a pixel.
    fn reach(&self, guide: &Guide, stride: u32) -> f32 {
        stride as f32 * self.pixel_angle * guide.position.distance(self.sampler.view.camera.eye)
    }

    fn divisor(&self, guide: &Guide) -> Vec3 {
        if self.sampler.view.mode == ViewMode::Shaded { guide.albedo } else { Vec3::ONE }
    }

    fn stride(&self, [x, y]: [u32; 2]) -> u32 {
        self.sketch.strides[self.sketch.tiles().place(x, y).0].unwrap_or(1)
    }
}
