//! Reference (b): light paths of any number of bounces, from the continuous environment and from local lights.
//!
//! Every path vertex gathers direct light by multiple importance sampling (Veach 1997): the environment by its texels and by the
//! BRDF; local lights by their area and, if they have one, by the BRDF; emissive surfaces by their power and by the BRDF. It uses
//! neither light samples nor cuts, so it shows the whole error. Where the view's mirrors show the scene, paths go on along sharp
//! lobes after their last bounce. Random numbers are seeded by pixel and pass.

mod emitters;
mod environment_sampling;
mod halves;
mod light_choice;
pub(crate) mod settings;
mod tracer;

use crate::{
    light::environment::Illumination,
    renderer::Renderer,
    shade::{
        background::{Backdrop, BlurCache},
        pixel_sampler::PixelSampler,
        seen_scene::SeenScene,
        surface::SurfacePoint,
    },
    view::{Preview, Progress, View, pixel_sample_position},
};
use glam::{DVec2, Vec3};
use halves::Halves;
pub use halves::PathPicture;
use lapidary_core::{image::Image, lights::Light};
use rayon::prelude::*;
use settings::{PathSettings, SamplePositions};
use tracer::Tracer;

impl Renderer {
    /// The scene under the continuous environment and local lights, in passes of one path per pixel. After cancellation, the
    /// picture of the complete passes.
    pub fn path_reference(
        &self,
        view: &View,
        light: &Illumination,
        lights: &[Light],
        settings: PathSettings,
        progress: &dyn Progress,
    ) -> Image {
        self.path_picture(view, light, lights, settings, progress).image
    }

    /// [`Self::path_reference`], and its noise.
    pub fn path_picture(
        &self,
        view: &View,
        light: &Illumination,
        lights: &[Light],
        settings: PathSettings,
        progress: &dyn Progress,
    ) -> PathPicture {
        self.refine();
        let shown = settings.components.environment;
        let backdrop = Backdrop::new(view, Some(light), shown, &mut BlurCache::default());
        let mut sampler = PixelSampler::new(self, view, &backdrop);
        if settings.positions == SamplePositions::Shifted {
            sampler = sampler.unfiltered(self);
        }
        let scene = view.mirrors.then(|| SeenScene::new(self, view, &backdrop));
        let tracer = Tracer::new(self, light, lights, settings, scene);
        let mut halves = Halves::new(view.size, view.aa);
        // At least one sample per position of the pixel pattern.
        let wanted = settings.spp.max(view.aa).max(1);
        for pass in 0..wanted {
            if progress.abandoned() || (progress.cancelled() && pass > 0) {
                break;
            }
            let image = trace_pass(&sampler, &tracer, pass, settings, progress);
            if progress.abandoned() {
                break;
            }
            halves.add(&image);
            let done = halves.passes();
            progress.advanced(done.into(), wanted.into());
            if progress.wants_preview(done) {
                let PathPicture { image, noise, .. } = halves.picture();
                progress.preview(&Preview { image: &image, step: 1, noise });
            }
        }
        halves.picture()
    }
}

/// One path for every pixel. Abandoned pixels stay black.
fn trace_pass(
    sampler: &PixelSampler,
    tracer: &Tracer,
    pass: u32,
    settings: PathSettings,
    progress: &dyn Progress,
) -> Image {
    let size = sampler.view.size;
    let mut image = Image::filled(size, Vec3::ZERO);
    let width = size[0] as usize;
    image.pixels.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        if progress.abandoned() {
            return;
        }
        for x in sampler.columns(y as u32) {
            let pixel = y * width + x as usize;
            let mut rng = fastrand::Rng::with_seed(seed(pixel, settings.first_pass + pass));
            let radiance = |point: &SurfacePoint| match point.slopes {
                [0.0, 0.0, 0.0] => tracer.radiance(point, &mut rng),
                _ => tracer.radiance(&point.with_one_normal([rng.f32(), rng.f32()]), &mut rng),
            };
            row[x as usize] = match settings.positions {
                SamplePositions::Shared => sampler.sample(x, y as u32, pass as usize, radiance),
                SamplePositions::Shifted => {
                    let position = pixel_sample_position(pass, shift(pixel, settings.first_pass));
                    sampler.sample_at(x, y as u32, position, radiance)
                }
            };
        }
    });
    image
}

/// Random shift of a pixel's pattern.
fn shift(pixel: usize, first_pass: u32) -> DVec2 {
    // Random numbers other than the path's in this pass.
    let mut rng = fastrand::Rng::with_seed(!seed(pixel, first_pass));
    DVec2::new(rng.f64(), rng.f64())
}

/// A seed for a pixel and pass, with all bits mixed (SplitMix64).
fn seed(pixel: usize, pass: u32) -> u64 {
    let mut z = (pixel as u64) << 32 | u64::from(pass);
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests;
