//! Reference (a): all light samples, with visibility traced at the pixel. It isolates what the cuts lose.
//!
//! Progressive in space: 16 passes over interleaved pixels, each pass exact where it has been.

use crate::{
    background::{Backdrop, BlurCache},
    frame::Frame,
    renderer::{Illumination, Renderer},
    surface::SurfacePoint,
    view::{Progress, View},
};
use glam::Vec3;
use lapidary_core::{image::Image, ray::DirectionSet, simd::Vec3x8};
use rayon::prelude::*;
use wide::f32x8;

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

impl Renderer {
    /// All light samples without cuts. If cancelled, pixels not reached repeat their block's first.
    pub fn samples_reference(&self, view: &View, light: &Illumination, progress: &dyn Progress) -> Image {
        let samples = LightSamples::new(self, light);
        let backdrop = Backdrop::new(view, light, &mut BlurCache::default());
        let frame = Frame::new(self, view, &backdrop);
        let mut image = Image::filled(view.size, Vec3::ZERO);
        let total = u64::from(view.size[0]) * u64::from(view.size[1]);
        let mut done = 0;
        for (pass, &(dx, dy)) in PASSES.iter().enumerate() {
            let rows: Vec<u32> = (dy..view.size[1]).step_by(4).collect();
            // Some rows at a time, so that a large picture can be cancelled between them.
            for rows in rows.chunks(16) {
                if progress.cancelled() {
                    fill_blocks(&mut image, pass);
                    return image;
                }
                let shade = |y: &u32| -> Vec<Vec3> {
                    let mut visible = vec![0; samples.directions.len()];
                    let mut pixel = |x| frame.pixel(x, *y, |point| samples.shade(self, point, &mut visible));
                    (dx..view.size[0]).step_by(4).map(&mut pixel).collect()
                };
                let shaded: Vec<Vec<Vec3>> = rows.par_iter().map(shade).collect();
                for (&y, row) in rows.iter().zip(shaded) {
                    for (i, value) in row.into_iter().enumerate() {
                        image.pixels[(y * view.size[0] + dx) as usize + 4 * i] = value;
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

/// Light samples in tree order, padded to whole groups of eight.
struct LightSamples {
    directions: DirectionSet,
    wi: Vec<Vec3x8>,
    radiance: Vec<Vec3x8>,
    solid_angle: f32,
}

impl LightSamples {
    fn new(renderer: &Renderer, light: &Illumination) -> Self {
        let tree = &renderer.dataset.tree;
        let lighting = renderer.lighting(light, 1);
        let leaf_radiance = &lighting.nodes.radiance[tree.len()..];
        let eight = |values: &[Vec3]| -> Vec<Vec3x8> {
            let lane = |chunk: &[Vec3], i: usize| chunk.get(i).copied().unwrap_or(Vec3::ZERO);
            values.chunks(8).map(|c| Vec3x8::from_array(std::array::from_fn(|i| lane(c, i)))).collect()
        };
        Self {
            directions: DirectionSet::new(tree.leaf_directions()),
            wi: eight(tree.leaf_directions()),
            radiance: eight(leaf_radiance),
            solid_angle: tree.leaf_solid_angle(),
        }
    }

    fn shade(&self, renderer: &Renderer, point: &SurfacePoint, visible: &mut [u8]) -> Vec3 {
        let (n, s) = (point.world_from_local.z_axis, point.smooth_normal);
        visible.fill(0);
        let received = |d: Vec3| d.dot(n) > 0.0 && d.dot(s) > 0.0;
        renderer.intersector.trace_batch(point.ray_origin, &self.directions, received, visible);
        let axes = [0, 1, 2].map(|i| Vec3x8::splat(point.world_from_local.col(i)));
        let brdf = point.brdf.as_brdf();
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for (i, seen) in visible.chunks(8).enumerate().filter(|(_, seen)| seen.iter().any(|&v| v != 0)) {
            let d = self.wi[i];
            let wi = Vec3x8 { x: d.dot(axes[0]), y: d.dot(axes[1]), z: d.dot(axes[2]) };
            let weight = f32x8::new(std::array::from_fn(|k| f32::from(seen.get(k).copied().unwrap_or(0))));
            sum = sum + brdf.brdf_cos_x8(wi, point.wo, f32x8::ZERO).scale(self.radiance[i]) * weight;
        }
        sum.reduce_add() * self.solid_angle
    }
}
