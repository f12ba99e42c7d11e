//! Pictures at growing illumination cuts and with lit cuts, then the reference, then the errors.

use super::{Cuts, SIZES, Truth};
use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{
    BackendError, LitScene, Look, Progress, RenderStats,
    compare::{Metrics, compare},
};

/// Settings of the ladder.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Cuts of each picture, in this order.
    pub cuts: Vec<Cuts>,
    /// Renderings per picture; its time is their median.
    pub frames: usize,
}

impl Settings {
    /// The usual sizes with the look's BRDF sampling, and lit cuts with the look's threshold.
    pub fn of(look: &Look) -> Self {
        Self::sizes(&SIZES, look)
    }

    /// [`Self::of`] with other `sizes`.
    pub fn sizes(sizes: &[u32], look: &Look) -> Self {
        let stored = sizes.iter().map(|&size| Cuts::stored(size, look.sampling));
        Self { cuts: stored.chain([Cuts::Lit(look.tau)]).collect(), frames: 1 }
    }
}

/// A picture with some cuts.
#[derive(Clone, Debug)]
pub struct Rung {
    /// The merged cuts.
    pub cuts: Cuts,
    /// The picture, scene-linear.
    pub image: Image,
    /// Statistics; the seconds are from the light to the last pixel.
    pub stats: RenderStats,
}

/// A picture and its error.
#[derive(Clone, Debug)]
pub struct Step {
    /// The picture.
    pub rung: Rung,
    /// Differences from the reference.
    pub metrics: Metrics,
}

/// All pictures and their reference.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// The reference.
    pub truth: Truth,
    /// In the order of the requested cuts.
    pub steps: Vec<Step>,
}

/// One result.
#[derive(Clone, Copy, Debug)]
pub enum Found<'a> {
    /// A picture, not yet compared.
    Picture(&'a Rung),
    /// The complete reference.
    Truth(&'a Truth),
    /// A picture with its error.
    Step(&'a Step),
}

/// Renders a look with each of the cuts, traces the reference unless it is `known`, and compares; passes each result to `found`.
/// `progress` follows the reference, which takes longest, and may cancel everything, which returns `None`.
///
/// # Errors
/// A failing renderer, or an error of `found`.
pub fn climb(
    scene: &mut LitScene,
    look: &Look,
    settings: &Settings,
    known: Option<Truth>,
    progress: &dyn Progress,
    found: &mut dyn FnMut(Found) -> Result<()>,
) -> Result<Option<Ladder>> {
    warm_up(scene, look)?;
    let mut rungs = Vec::with_capacity(settings.cuts.len());
    for &cuts in &settings.cuts {
        if progress.cancelled() {
            return Ok(None);
        }
        let rung = median_rung(scene, look, cuts, settings.frames)?;
        found(Found::Picture(&rung))?;
        rungs.push(rung);
    }
    let truth = known.map_or_else(|| Truth::trace(scene.baked(), look, progress), Ok)?;
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

/// Seconds per picture, `count` with each of the cuts, from the light to the last pixel.
///
/// # Errors
/// A failing renderer.
pub fn time_frames(scene: &mut LitScene, look: &Look, cuts: &[Cuts], count: usize) -> Result<Vec<Vec<f64>>> {
    warm_up(scene, look)?;
    let mut times = |cuts: Cuts| {
        let frame = |_| rung(scene, look, cuts).map(|rung| rung.stats.seconds);
        (0..count).map(frame).collect::<Result<Vec<f64>, _>>()
    };
    Ok(cuts.iter().map(|&cuts| times(cuts)).collect::<Result<_, _>>()?)
}

/// Does the shared work of all pictures, so that no picture's time includes it: shadow rays from sources to lights, the resampled
/// environment, shaders.
fn warm_up(scene: &mut LitScene, look: &Look) -> Result<(), BackendError> {
    scene.light(&Look { illum_cut: 1, ..look.clone() })?;
    scene.begin(&look.view, look.sampling)?;
    scene.render_rows(0, 0..1)
}

/// The picture with the median time.
fn median_rung(scene: &mut LitScene, look: &Look, cuts: Cuts, frames: usize) -> Result<Rung, BackendError> {
    let frame = |_| rung(scene, look, cuts);
    let mut rungs = (0..frames.max(1)).map(frame).collect::<Result<Vec<_>, _>>()?;
    rungs.sort_by(|a, b| a.stats.seconds.total_cmp(&b.stats.seconds));
    Ok(rungs.swap_remove(rungs.len() / 2))
}

/// A picture with recomputed light: the time of lit cuts includes making them.
fn rung(scene: &mut LitScene, look: &Look, cuts: Cuts) -> Result<Rung, BackendError> {
    scene.forget_light();
    let picture = scene.show_whole(&cuts.shown(look))?;
    Ok(Rung { cuts, image: picture.image, stats: picture.stats })
}
