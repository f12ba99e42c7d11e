//! Reuse of the last picture under a new camera: reverse reprojection (Nehab et al., Accelerating Real-Time Shading with Reverse
//! Reprojection Caching, 2007).
//!
//! A surface point that the last picture also shows is found there, with its reflected light. Only the detail between lattice
//! points is reused: the last picture's value minus its own filtered value. Light at the lattice points is computed anew. The
//! detail is trusted as far as the last picture agrees with the lattice, so a reflection that moves with the eye is dropped. Twin
//! of `history_pass.wgsl`, `past.wgsl` and `predict_pass.wgsl`, and of `detail` in `sketch_pass.wgsl`.

use crate::{
    cpu::picture::Picture,
    sketch::{Guide, Mean},
    stale::LightPart,
};
use glam::{Vec2, Vec3};
use lapidary_core::{camera::Projection, color::luminance};
use rayon::prelude::*;

/// The surface in a pixel of the last picture.
#[derive(Clone, Copy, Debug, Default)]
struct Past {
    material: u32,
    /// Position in meters.
    position: Vec3,
    /// Unit normal after bump and normal map.
    normal: Vec3,
}

/// The last picture, row by row.
#[derive(Default)]
pub(super) struct History {
    projection: Option<Projection>,
    size: [u32; 2],
    points: Vec<Past>,
    /// Radiance over albedo by [`LightPart`]; empty for parts that the light lacked.
    values: [Vec<Vec3>; LightPart::COUNT],
    /// Predicted values of the new picture's pixels by [`LightPart`]; empty before [`Self::predict`].
    predicted: [Vec<Option<Vec3>>; LightPart::COUNT],
    /// Pixels in a row of the new picture.
    width: u32,
}

impl History {
    /// Takes a displayed picture whose pixels have these guides. Reuses the buffers of `former`.
    pub fn new<'g>(
        projection: Projection,
        picture: &Picture,
        guide: impl Fn(u32, u32) -> &'g Guide + Sync,
        former: Option<Self>,
    ) -> Self {
        let Self { mut points, mut values, mut predicted, .. } = former.unwrap_or_default();
        let size = picture.size();
        by_rows(&mut points, size, |x, y| {
            let &Guide { material, position, normal, .. } = guide(x, y);
            Past { material: if picture.sees_one_surface(x, y) { material } else { Guide::BACK }, position, normal }
        });
        for part in LightPart::ALL {
            let of_part = if picture.has_part(part) { size } else { [0, 0] };
            by_rows(&mut values[part as usize], of_part, |x, y| picture.shown(part, x, y) / guide(x, y).albedo);
        }
        // A new picture has all its local lights in one part.
        let [.., direct, added] = &mut values;
        direct.iter_mut().zip(added.drain(..)).for_each(|(direct, added)| *direct += added);
        predicted.iter_mut().for_each(Vec::clear);
        Self { projection: Some(projection), size, points, values, predicted, width: 0 }
    }

    /// Predicts the pixels of a picture of `size` with these guides, unless already done.
    pub fn predict<'g>(&mut self, guide: impl Fn(u32, u32) -> &'g Guide + Sync, size: [u32; 2]) {
        let Some(projection) = self.projection.take() else { return };
        let Self { points, values, predicted, size: from, .. } = self;
        for (values, predicted) in values.iter().zip(predicted).filter(|(values, _)| !values.is_empty()) {
            // Points are found again for each part, which is faster than storing them.
            by_rows(predicted, size, |x, y| Found::of(guide(x, y), &projection, points, *from)?.mean(values));
        }
        self.width = size[0];
    }

    /// Predicted radiance over albedo of a pixel in the new picture.
    pub fn predicted(&self, part: LightPart, x: u32, y: u32) -> Option<Vec3> {
        *self.predicted[part as usize].get((y * self.width + x) as usize)?
    }
}

/// Values of all pixels of a picture, row by row.
fn by_rows<T: Send + Default + Clone>(to: &mut Vec<T>, size: [u32; 2], value: impl Fn(u32, u32) -> T + Sync) {
    to.resize(size[0] as usize * size[1] as usize, T::default());
    to.par_chunks_mut(size[0].max(1) as usize).zip(0..size[1]).for_each(|(row, y)| {
        row.iter_mut().zip(0..).for_each(|(to, x)| *to = value(x, y));
    });
}

/// A surface point located in the last picture.
struct Found {
    /// Surrounding pixels of the last picture.
    pixels: [usize; 4],
    /// Pixel weights; zero for pixels of another surface.
    weights: [f32; 4],
}

impl Found {
    fn of(guide: &Guide, projection: &Projection, points: &[Past], size: [u32; 2]) -> Option<Self> {
        let (pixel, depth) = projection.pixel_of(guide.position).filter(|_| guide.is_lit())?;
        // The first sample of a pixel is at its center.
        let place = pixel - 0.5;
        let first = place.floor();
        let f = place - first;
        let reach = depth / projection.focal;
        let (mut pixels, mut weights) = ([0; 4], [0.0; 4]);
        for (i, (pixel, weight)) in pixels.iter_mut().zip(&mut weights).enumerate() {
            let corner = Vec2::new((i % 2) as f32, (i / 2) as f32);
            let Vec2 { x, y } = first + corner;
            // Compared as floats: a place near the eye's plane may exceed all integers.
            if !(x >= 0.0 && y >= 0.0 && x < size[0] as f32 && y < size[1] as f32) {
                continue;
            }
            *pixel = y as usize * size[0] as usize + x as usize;
            let Past { material, position, normal } = points[*pixel];
            let tent = Vec2::ONE - (f - corner).abs();
            *weight = tent.x * tent.y * guide.fit_surface(material, position, normal, reach);
        }
        Some(Self { pixels, weights })
    }

    /// The mean of the pixels' values, if enough of them fit.
    fn mean(&self, values: &[Vec3]) -> Option<Vec3> {
        let mut mean = Mean::default();
        let fitting = self.pixels.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0);
        fitting.for_each(|(&pixel, weight)| mean.add(values[pixel], weight));
        mean.fitting(1)
    }
}

/// Difference of the last picture from its own filtered value at a pixel, and its reliability.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detail {
    value: Vec3,
    filtered: Mean,
    /// Sums of the smaller and of the larger luminance of each pair before and now.
    least: f32,
    most: f32,
}

impl Detail {
    /// Starts with the last picture's value at the pixel.
    pub fn of(value: Vec3) -> Self {
        Self { value, filtered: Mean::default(), least: 0.0, most: 0.0 }
    }

    /// Adds a lattice point: its value in the last picture and in this one.
    pub fn add(&mut self, before: Vec3, now: Vec3, weight: f32) {
        self.filtered.add(before, weight);
        let (before, now) = (luminance(before), luminance(now));
        self.least += weight * before.min(now);
        self.most += weight * before.max(now);
    }

    /// The detail, as far as the two pictures agree.
    pub fn trusted(self) -> Vec3 {
        let trust = if self.most > 0.0 { self.least / self.most } else { 0.0 };
        self.filtered.any().map_or(Vec3::ZERO, |filtered| trust * (self.value - filtered))
    }
}

#[cfg(test)]
mod tests;
