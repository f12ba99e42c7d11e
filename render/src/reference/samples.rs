//! Reference (a): all light samples, with visibility traced at the pixel. It isolates the error of the cuts, for the environment
//! (samples are directions) and for bounced light (samples are surface sources).
//!
//! It is progressive in space: 16 passes over interleaved pixels, exact at their pixels.

pub(crate) mod distant;
pub(crate) mod sources;

use crate::{
    light::{bounce::SourceLighting, environment::Illumination},
    renderer::Renderer,
    sampling::BrdfSampling,
    shade::{
        background::{Backdrop, BlurCache},
        direct::{DirectLights, DirectShader, ray_shift},
        merge::SharpLight,
        mirror::rays::brightest_by_rays,
        mirrors::{Mirrors, cone::CameraCones},
        pixel_sampler::PixelSampler,
        point_shader::PointShader,
        seen_scene::SeenScene,
        surface::SurfacePoint,
    },
    view::{Preview, Progress, View},
};
use distant::{DistantShader, LightSamples};
use glam::{Vec2, Vec3};
use lapidary_core::{image::Image, lights::Light};
use rayon::prelude::*;
use sources::{SourceSamples, SourceShader};

/// Pixels of a 4 x 4 block in the order of the passes: each pass halves the distance to the nearest finished pixel.
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

/// Sums two kinds of samples, emission, and what mirrors show. Each may be left out.
struct Sum<'a> {
    distant: Option<DistantShader<'a>>,
    sources: Option<SourceShader<'a>>,
    emission: bool,
    mirrors: Option<Mirrors<'a>>,
    /// Direct light of what mirrors show.
    direct: &'a DirectShader<'a>,
}

impl Sum<'_> {
    /// Radiance toward the eye without direct light; `shift` comes from [`ray_shift`].
    fn shade(&mut self, point: &SurfacePoint, shift: Vec2) -> Vec3 {
        let Some(mirrors) = self.mirrors else { return self.sampled(point, SharpLight::Map) };
        let direct = self.direct;
        let sampled = self.sampled(point, mirrors.sharp());
        let mut shown = |point: &SurfacePoint, sharp, shift| {
            self.sampled(point, sharp) + direct.reflected(&point.within_cone(), shift)
        };
        sampled + mirrors.shown(point, shift, &mut shown)
    }

    fn sampled(&mut self, point: &SurfacePoint, sharp: SharpLight) -> Vec3 {
        let distant = self.distant.as_mut().map(|shader| {
            shader.sharp = sharp;
            shader.shade(point)
        });
        let sources = self.sources.as_mut().map(|shader| {
            shader.sharp = sharp;
            shader.shade(point)
        });
        let emitted = if self.emission { point.emission } else { Vec3::ZERO };
        emitted + distant.unwrap_or_default() + sources.unwrap_or_default()
    }
}

/// The light of a picture without cuts.
#[derive(Clone, Copy, Default)]
pub struct SampledLight<'a> {
    /// Environment: all its light samples, and its map as the background.
    pub environment: Option<&'a Illumination>,
    /// Local lights, for direct light.
    pub lights: &'a [Light],
    /// Whether emission of surfaces is shown.
    pub emission: bool,
    /// Surface sources, all of them.
    pub sources: Option<&'a SourceLighting>,
    /// A picture of other light to add.
    pub base: Option<&'a Image>,
}

impl Renderer {
    /// All light samples of the environment, without cuts. After cancellation, unfinished pixels repeat a finished one of their
    /// block.
    pub fn samples_reference(&self, view: &View, light: &Illumination, progress: &dyn Progress) -> Image {
        self.sampled(view, SampledLight { environment: Some(light), ..Default::default() }, progress)
    }

    /// Light of all surface sources without cuts, on black; cancellation as in [`Self::samples_reference`].
    pub fn sources_reference(&self, view: &View, lighting: &SourceLighting, progress: &dyn Progress) -> Image {
        self.sampled(view, SampledLight { sources: Some(lighting), ..Default::default() }, progress)
    }

    /// Light of all kinds without cuts; cancellation as in [`Self::samples_reference`].
    pub fn sampled(&self, view: &View, light: SampledLight, progress: &dyn Progress) -> Image {
        self.refine();
        let distant =
            light.environment.map(|environment| LightSamples::of(&self.dataset.tree, &self.lighting(environment, 1)));
        let sources = light.sources.map(|lighting| SourceSamples::new(self, lighting));
        let backdrop = Backdrop::new(view, light.environment, light.environment.is_some(), &mut BlurCache::default());
        let suns = light.environment.map_or_else(Vec::new, Illumination::suns);
        let lights = [light.lights, &suns].concat();
        let shown = DirectLights { lights: &lights, intersector: self.intersector() }.shader();
        let scene = SeenScene::in_mirrors(self, view, BrdfSampling::Refine, &backdrop);
        let mirrors = scene.map(|scene| Mirrors {
            scene,
            map: distant.as_ref().and_then(LightSamples::map),
            leaf_solid_angle: self.dataset.tree.leaf_solid_angle(),
            brightest: brightest_by_rays(light.sources),
            cones: CameraCones::of(view),
        });
        let shader = || Sum {
            distant: distant.as_ref().map(|samples| samples.shader(self)),
            sources: sources.as_ref().map(|samples| samples.shader(self)),
            emission: light.emission,
            mirrors,
            direct: &shown,
        };
        let direct = (!lights.is_empty()).then(|| self.direct_light_before(light.environment, view, &lights));
        let bases = [light.base, direct.as_ref()];
        let progress = OverBases { bases, inner: progress };
        let mut image = self.in_passes(&PixelSampler::new(self, view, &backdrop), shader, &progress);
        bases.into_iter().flatten().for_each(|base| image.add(base));
        image
    }

    fn in_passes<'a>(
        &self,
        sampler: &PixelSampler,
        shader: impl Fn() -> Sum<'a> + Sync,
        progress: &dyn Progress,
    ) -> Image {
        let size = sampler.view.size;
        let mut image = Image::filled(size, Vec3::ZERO);
        let total = (0..size[1]).map(|y| sampler.columns(y).len() as u64).sum();
        let mut done = 0;
        for (pass, &(dx, dy)) in PASSES.iter().enumerate() {
            let rows: Vec<u32> = (dy..size[1]).step_by(4).collect();
            // A few rows at a time, so a large picture can be cancelled.
            for rows in rows.chunks(16) {
                if progress.cancelled() || progress.abandoned() {
                    fill_blocks(&mut image, pass);
                    return image;
                }
                let shade = |y: &u32| -> Vec<(u32, Vec3)> {
                    let mut shader = shader();
                    let columns = sampler.columns(*y).filter(|x| x % 4 == dx && !progress.abandoned());
                    let mut sample =
                        |x, i| sampler.sample(x, *y, i as usize, |point| shader.shade(point, ray_shift(x, *y, i)));
                    let samples = sampler.view.aa.max(1);
                    let mut mean = |x| (0..samples).map(|i| sample(x, i)).sum::<Vec3>() / samples as f32;
                    columns.map(|x| (x, mean(x))).collect()
                };
                let shaded: Vec<Vec<(u32, Vec3)>> = rows.par_iter().map(shade).collect();
                for (&y, row) in rows.iter().zip(shaded) {
                    done += row.len() as u64;
                    row.into_iter().for_each(|(x, value)| image.pixels[(y * size[0] + x) as usize] = value);
                }
                progress.advanced(done, total);
            }
            if let Some(step) = step_after(pass + 1) {
                let mut coarse = image.clone();
                fill_blocks(&mut coarse, pass + 1);
                progress.preview(&Preview { image: &coarse, step, noise: None });
            }
        }
        image
    }
}

/// Adds the base pictures to the previews.
struct OverBases<'a> {
    bases: [Option<&'a Image>; 2],
    inner: &'a dyn Progress,
}

impl Progress for OverBases<'_> {
    fn advanced(&self, done: u64, total: u64) {
        self.inner.advanced(done, total);
    }

    fn preview(&self, preview: &Preview) {
        let mut image = preview.image.clone();
        self.bases.iter().flatten().for_each(|base| image.add(base));
        self.inner.preview(&Preview { image: &image, ..*preview });
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }

    fn abandoned(&self) -> bool {
        self.inner.abandoned()
    }
}

/// Spacing of complete pixels after a number of passes, if it has changed.
fn step_after(passes: usize) -> Option<u32> {
    [(1, 4), (4, 2), (16, 1)].into_iter().find(|&(p, _)| p == passes).map(|(_, step)| step)
}

/// Copies to unfinished pixels the value of the nearest finished pixel to the upper left in their block.
fn fill_blocks(image: &mut Image, finished: usize) {
    let [width, height] = image.size;
    let step = match finished {
        0 => return,
        1..4 => 4,
        4..16 => 2,
        _ => 1,
    };
    for y in 0..height {
        for x in 0..width {
            let reached = PASSES[..finished].contains(&(x % 4, y % 4));
            if !reached {
                image.pixels[(y * width + x) as usize] = image.at((x - x % step) as usize, (y - y % step) as usize);
            }
        }
    }
}
