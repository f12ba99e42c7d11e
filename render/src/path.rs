//! Reference (b): the continuous environment, by multiple importance sampling (Veach 1997) of light and BRDF.
//!
//! Unlike all else here it knows no light samples: it shows the whole error. Seeded by pixel and sample.

mod environment_sampling;

use crate::{
    background::{Backdrop, BlurCache, Sky},
    frame::Frame,
    renderer::{Illumination, Renderer},
    surface::SurfacePoint,
    view::{Progress, View},
};
use environment_sampling::EnvironmentDistribution;
use glam::Vec3;
use lapidary_core::image::Image;
use rayon::prelude::*;

impl Renderer {
    /// Direct light of the continuous environment, `spp` samples a pixel in passes of one each. If cancelled, the
    /// picture of the passes that are complete.
    pub fn path_reference(&self, view: &View, light: &Illumination, spp: u32, progress: &dyn Progress) -> Image {
        let distribution = EnvironmentDistribution::new(&light.environment.map);
        let backdrop = Backdrop::new(view, light, &mut BlurCache::default());
        let frame = Frame::new(self, view, &backdrop);
        let sky = Sky::new(light);
        let tracer = DirectLight { renderer: self, sky: &sky, distribution: &distribution };
        let mut sum = Image::filled(view.size, Vec3::ZERO);
        let mut passes = 0_u32;
        // At least one sample for each position of the pixel pattern.
        for pass in 0..spp.max(view.aa).max(1) {
            if progress.cancelled() && passes > 0 {
                break;
            }
            let width = view.size[0] as usize;
            sum.pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    let mut rng = fastrand::Rng::with_seed(seed(y * width + x, pass));
                    *pixel += frame.sample(x as u32, y as u32, pass as usize, |p| tracer.sample(p, &mut rng));
                }
            });
            passes += 1;
            progress.advanced(u64::from(pass) + 1, u64::from(spp));
            if passes.is_power_of_two() {
                progress.preview(&scaled(&sum, passes));
            }
        }
        scaled(&sum, passes)
    }
}

fn scaled(sum: &Image, passes: u32) -> Image {
    Image { size: sum.size, pixels: sum.pixels.iter().map(|&p| p / passes as f32).collect() }
}

/// A seed for a pixel and pass, with all bits mixed (SplitMix64).
fn seed(pixel: usize, pass: u32) -> u64 {
    let mut z = (pixel as u64) << 32 | u64::from(pass);
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// One-sample estimates of direct light.
struct DirectLight<'a> {
    renderer: &'a Renderer,
    sky: &'a Sky<'a>,
    distribution: &'a EnvironmentDistribution,
}

impl DirectLight<'_> {
    fn sample(&self, point: &SurfacePoint, rng: &mut fastrand::Rng) -> Vec3 {
        self.by_light(point, rng) + self.by_brdf(point, rng)
    }

    fn by_light(&self, point: &SurfacePoint, rng: &mut fastrand::Rng) -> Vec3 {
        let Some((direction, pdf)) = self.distribution.sample(rng.f32(), rng.f32()) else { return Vec3::ZERO };
        let world = self.sky.to_world(direction);
        let wi = point.world_from_local.transpose() * world;
        let other = point.brdf.as_brdf().pdf(wi, point.wo);
        self.received(point, world, wi) * (power_heuristic(pdf, other) / pdf)
    }

    fn by_brdf(&self, point: &SurfacePoint, rng: &mut fastrand::Rng) -> Vec3 {
        let brdf = point.brdf.as_brdf();
        let wi = brdf.sample(point.wo, Vec3::new(rng.f32(), rng.f32(), rng.f32()));
        let pdf = brdf.pdf(wi, point.wo);
        if !(wi.z > 0.0 && pdf > 0.0) {
            return Vec3::ZERO;
        }
        let world = point.world_from_local * wi;
        let other = self.distribution.pdf(self.sky.to_environment(world));
        self.received(point, world, wi) * (power_heuristic(pdf, other) / pdf)
    }

    /// Radiance times BRDF and cosine, zero if blocked.
    fn received(&self, point: &SurfacePoint, world: Vec3, wi: Vec3) -> Vec3 {
        if !(wi.z > 0.0 && world.dot(point.smooth_normal) > 0.0) {
            return Vec3::ZERO;
        }
        let value = point.brdf.as_brdf().brdf_cos(wi, point.wo) * self.sky.radiance(world);
        if value == Vec3::ZERO || self.renderer.intersector.occluded(point.ray_origin, world) {
            return Vec3::ZERO;
        }
        value
    }
}

fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let (a, b) = (pdf * pdf, other * other);
    if a.is_infinite() { 1.0 } else { a / (a + b) }
}
