//! Reference (b): light paths of any number of bounces, from the continuous environment and from local lights.
//!
//! Every vertex of a path gathers direct light by multiple importance sampling (Veach 1997): of the environment by its
//! texels and by the BRDF, of local lights by their area and, where they have one, by the BRDF. Unlike all else here it
//! knows neither light samples nor cuts: it shows the whole error. Seeded by pixel and pass.

mod environment_sampling;
mod light_choice;
mod tracer;

use crate::{
    background::{Backdrop, BlurCache},
    components::Components,
    frame::Frame,
    region::Region,
    renderer::{Illumination, Renderer},
    view::{Progress, View},
};
use glam::Vec3;
use lapidary_core::{image::Image, lights::Light};
use rayon::prelude::*;
use tracer::Tracer;

/// What [`Renderer::path_reference`] follows, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// Paths a pixel; noise falls with the square root.
    pub spp: u32,
    /// Number of the first path: pictures of other paths have other noise.
    pub first_pass: u32,
    /// Most reflections of light between surfaces before the one toward the eye: 0 is direct light, 1 adds one indirect
    /// bounce.
    pub bounces: u32,
    /// What of the light is in the picture.
    pub components: Components,
}

impl PathSettings {
    /// All direct light.
    pub fn direct(spp: u32) -> Self {
        Self { spp, first_pass: 0, bounces: 0, components: Components::ALL }
    }
}

impl Renderer {
    /// The scene under the continuous environment and local lights, in passes of one path a pixel. If cancelled, the
    /// picture of the passes that are complete.
    pub fn path_reference(
        &self,
        view: &View,
        light: &Illumination,
        lights: &[Light],
        settings: PathSettings,
        progress: &dyn Progress,
    ) -> Image {
        self.path_region(view, Region::whole(view.size), light, lights, settings, progress)
    }

    /// The part of [`Self::path_reference`] that `region` is: the same paths, and no others.
    pub fn path_region(
        &self,
        view: &View,
        region: Region,
        light: &Illumination,
        lights: &[Light],
        settings: PathSettings,
        progress: &dyn Progress,
    ) -> Image {
        let backdrop = if settings.components.environment {
            Backdrop::new(view, light, &mut BlurCache::default())
        } else {
            Backdrop::black()
        };
        let frame = Frame::new(self, view, &backdrop);
        let tracer = Tracer::new(self, light, lights, settings);
        let mut sum = Image::filled(region.size(), Vec3::ZERO);
        let mut passes = 0_u32;
        // At least one sample for each position of the pixel pattern.
        let wanted = settings.spp.max(view.aa).max(1);
        for pass in 0..wanted {
            if progress.cancelled() && passes > 0 {
                break;
            }
            let rows = sum.pixels.par_chunks_mut(region.width.max(1) as usize).zip(region.rows().into_par_iter());
            rows.for_each(|(row, y)| {
                for (pixel, x) in row.iter_mut().zip(region.columns()) {
                    let number = y as usize * view.size[0] as usize + x as usize;
                    let mut rng = fastrand::Rng::with_seed(seed(number, settings.first_pass + pass));
                    *pixel += frame.sample(x, y, pass as usize, |p| tracer.radiance(p, &mut rng));
                }
            });
            passes += 1;
            progress.advanced(u64::from(pass) + 1, u64::from(wanted));
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

#[cfg(test)]
mod tests;
