//! Reference (b): light paths of any number of bounces, from the continuous environment and from local lights.
//!
//! Every vertex of a path gathers direct light by multiple importance sampling (Veach 1997): of the environment by its
//! texels and by the BRDF, of local lights by their area and, where they have one, by the BRDF. Unlike all else here it
//! knows neither light samples nor cuts: it shows the whole error. Seeded by pixel and pass.

mod environment_sampling;
mod halves;
mod light_choice;
mod tracer;

use crate::{
    background::{Backdrop, BlurCache},
    components::Components,
    frame::Frame,
    renderer::{Illumination, Renderer},
    surface::SurfacePoint,
    view::{Preview, Progress, View, place_in_pixel},
};
use glam::{DVec2, Vec3};
use halves::Halves;
pub use halves::PathPicture;
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
    /// Where in the pixels paths begin.
    pub places: Places,
}

/// Where in its pixel a path begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Places {
    /// Where cuts are shaded ([`View::pixel_offsets`]): pictures of the two differ by light alone.
    #[default]
    Shared,
    /// Anywhere: in each pixel, and for each first path, the pattern is shifted by another random vector (Cranley and
    /// Patterson 1976), and no place comes twice. The mean is that over the whole pixel, as other renderers have it, and
    /// what a pattern misses is noise.
    Shifted,
}

impl PathSettings {
    /// All direct light.
    pub fn direct(spp: u32) -> Self {
        Self { spp, first_pass: 0, bounces: 0, components: Components::ALL, places: Places::Shared }
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
        let backdrop = if settings.components.environment {
            Backdrop::new(view, light, &mut BlurCache::default())
        } else {
            Backdrop::black()
        };
        let frame = Frame::new(self, view, &backdrop);
        let tracer = Tracer::new(self, light, lights, settings);
        let mut halves = Halves::new(view.size, view.aa);
        // At least one sample for each position of the pixel pattern.
        let wanted = settings.spp.max(view.aa).max(1);
        for pass in 0..wanted {
            if progress.abandoned() || (progress.cancelled() && pass > 0) {
                break;
            }
            let image = trace_pass(&frame, &tracer, pass, settings, progress);
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

/// One path for every pixel. What is abandoned stays black.
fn trace_pass(frame: &Frame, tracer: &Tracer, pass: u32, settings: PathSettings, progress: &dyn Progress) -> Image {
    let size = frame.view.size;
    let mut image = Image::filled(size, Vec3::ZERO);
    let width = size[0] as usize;
    image.pixels.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        if progress.abandoned() {
            return;
        }
        for x in frame.columns(y as u32) {
            let pixel = y * width + x as usize;
            let mut rng = fastrand::Rng::with_seed(seed(pixel, settings.first_pass + pass));
            let radiance = |point: &SurfacePoint| tracer.radiance(point, &mut rng);
            row[x as usize] = match settings.places {
                Places::Shared => frame.sample(x, y as u32, pass as usize, radiance),
                Places::Shifted => {
                    let place = place_in_pixel(pass, shift(pixel, settings.first_pass));
                    frame.sample_at(x, y as u32, place, radiance)
                }
            };
        }
    });
    image
}

/// Where a pixel's pattern begins.
fn shift(pixel: usize, first_pass: u32) -> DVec2 {
    // Other numbers than those of the pass's path.
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
