//! Pictures at growing illumination cuts, then the truth, then the errors.

use super::{Subject, Truth};
use crate::whole_picture::{stats, whole_picture};
use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{
    Backend, BrdfSampling, LightRig, LocalRig, Progress, RenderStats,
    compare::{Metrics, compare},
};
use std::{sync::Arc, time::Instant};

/// How the ladder is climbed.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Most nodes of the illumination cut, for each picture.
    pub sizes: Vec<u32>,
    /// How the BRDF is sampled.
    pub sampling: BrdfSampling,
    /// How often each picture is rendered, for its time is the median.
    pub frames: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { sizes: super::SIZES.into(), sampling: BrdfSampling::default(), frames: 1 }
    }
}

/// A picture at one size.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Most nodes of the illumination cut.
    pub illum_cut: u32,
    /// The picture, scene-linear.
    pub image: Image,
    /// How it was made; the seconds are those from the light to the last pixel.
    pub stats: RenderStats,
}

/// A picture and its error.
#[derive(Clone, Debug)]
pub struct Step {
    /// The picture.
    pub rung: Rung,
    /// Its differences from the truth.
    pub metrics: Metrics,
}

/// All pictures and what they are held against.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// The reference.
    pub truth: Truth,
    /// In the order of the sizes asked for.
    pub steps: Vec<Step>,
}

/// What is known so far.
#[derive(Clone, Copy, Debug)]
pub enum Found<'a> {
    /// A picture, not compared yet.
    Picture(&'a Rung),
    /// The reference, finished.
    Truth(&'a Truth),
    /// A picture with its error.
    Step(&'a Step),
}

/// Renders at each size, traces the truth unless it is `known`, and compares; hands each result to `found` as it comes.
/// `progress` hears of the truth, which takes longest, and may stop all of it: `None` then.
///
/// # Errors
/// A renderer that fails, or what `found` says.
pub fn climb(
    subject: &Subject,
    settings: &Settings,
    backend: &mut dyn Backend,
    known: Option<Truth>,
    progress: &dyn Progress,
    found: &mut dyn FnMut(Found) -> Result<()>,
) -> Result<Option<Ladder>> {
    let mut stage = Stage::new(subject, backend)?;
    let mut rungs = Vec::with_capacity(settings.sizes.len());
    for &size in &settings.sizes {
        if progress.cancelled() {
            return Ok(None);
        }
        let rung = stage.median_rung(size, settings)?;
        found(Found::Picture(&rung))?;
        rungs.push(rung);
    }
    let truth = known.map_or_else(|| Truth::trace(subject, progress), Ok)?;
    if progress.cancelled() {
        return Ok(None);
    }
    found(Found::Truth(&truth))?;
    let mut steps = Vec::with_capacity(rungs.len());
    for rung in rungs {
        let step = Step { metrics: compare(&rung.image, &truth.image)?, rung };
        found(Found::Step(&step))?;
        steps.push(step);
    }
    Ok(Some(Ladder { truth, steps }))
}

/// Seconds of pictures, `count` at each size, from the light to the last pixel.
///
/// # Errors
/// A renderer that fails.
pub fn time_frames(
    subject: &Subject,
    settings: &Settings,
    backend: &mut dyn Backend,
    count: usize,
) -> Result<Vec<Vec<f64>>> {
    let mut stage = Stage::new(subject, backend)?;
    let mut times = |size: u32| {
        let frame = |_| stage.rung(size, settings.sampling).map(|rung| rung.stats.seconds);
        (0..count).map(frame).collect::<Result<Vec<f64>>>()
    };
    settings.sizes.iter().map(|&size| times(size)).collect()
}

/// A lit scene on a renderer.
struct Stage<'a> {
    subject: &'a Subject,
    backend: &'a mut dyn Backend,
    rig: LightRig,
    local: LocalRig,
}

impl<'a> Stage<'a> {
    /// Whatever is done once for all pictures is done here, so that no picture's time has it: loading, shadow rays from sources
    /// to lights, the resampled environment, shaders.
    fn new(subject: &'a Subject, backend: &'a mut dyn Backend) -> Result<Self> {
        backend.set_scene(&subject.baked)?;
        backend.set_appearance(&subject.appearance)?;
        let mut local = LocalRig::new(&subject.baked);
        local.set_appearance(&subject.appearance.fitted(&subject.dataset().scene.materials).0);
        local.set_lights(&subject.lights);
        let mut stage = Self { subject, backend, rig: LightRig::new(&subject.dataset().tree), local };
        stage.light(1)?;
        stage.backend.begin(&subject.view, BrdfSampling::default())?;
        stage.backend.render_rows(0, 0..1)?;
        Ok(stage)
    }

    /// Lights the scene anew with an illumination cut of at most `size` nodes.
    fn light(&mut self, size: u32) -> Result<()> {
        let Subject { light, components, solution, .. } = self.subject;
        let lighting = Arc::new(self.rig.lighting(light, size));
        self.backend.set_light(light, &lighting)?;
        self.local.set_environment(Some(&lighting));
        self.backend.set_local_lighting(&self.local.lighting(*components, *solution, size))?;
        Ok(())
    }

    /// The picture whose time is the median.
    fn median_rung(&mut self, size: u32, settings: &Settings) -> Result<Rung> {
        let frame = |_| self.rung(size, settings.sampling);
        let mut rungs = (0..settings.frames.max(1)).map(frame).collect::<Result<Vec<_>>>()?;
        rungs.sort_by(|a, b| a.stats.seconds.total_cmp(&b.stats.seconds));
        Ok(rungs.swap_remove(rungs.len() / 2))
    }

    fn rung(&mut self, size: u32, sampling: BrdfSampling) -> Result<Rung> {
        let start = Instant::now();
        self.light(size)?;
        let (image, _) = whole_picture(self.backend, &self.subject.view, sampling)?;
        let stats = stats(self.backend, start.elapsed().as_secs_f64())?;
        Ok(Rung { illum_cut: size, image, stats })
    }
}
