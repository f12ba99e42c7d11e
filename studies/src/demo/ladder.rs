//! The ladder of the still life, with the BRDF once and refined, and a close-up against light paths.

use super::{
    data::Environments,
    stage::{Picture, PictureSettings, Stage},
    steps::Steps,
};
use crate::{
    ladder::{self, Settings, Step, Subject, Truth},
    terminal::Interrupted,
};
use anyhow::Result;
use lapidary_core::dataset::Dataset;
use lapidary_render::{
    BrdfSampling, CpuBackend, PathSettings, Progress,
    compare::{
        Metrics, compare,
        map::{ErrorMap, error_map},
    },
};
use serde::Serialize;
use std::{path::Path, sync::Arc, time::Instant};

/// Sizes of the illumination cut.
pub const CUT_SIZES: [u32; 5] = [32, 64, 128, 256, 512];

/// Errors at the upper end of all maps, so that they can be compared.
pub const MAP_TOP: f32 = 0.5;

/// Samples a pixel of the path-traced reference.
pub const PATH_SAMPLES: u32 = 64;

/// One cut size and way of sampling the BRDF.
#[derive(Clone, Debug, Serialize)]
pub struct Rung {
    /// The picture.
    pub picture: Picture,
    /// Its differences from the samples reference.
    pub metrics: Metrics,
    /// File of the map of relative error.
    pub error_map: String,
}

/// Pictures of the knot and the vase, close.
#[derive(Clone, Debug, Serialize)]
pub struct Detail {
    /// BRDF once a node.
    pub once: Picture,
    /// BRDF refined.
    pub refined: Picture,
    /// By path tracing.
    pub path_reference: Picture,
    /// Differences of the first from the last.
    pub metrics_once: Metrics,
    /// Differences of the second from the last.
    pub metrics_refined: Metrics,
}

/// All rungs and what they are held against.
#[derive(Clone, Debug, Serialize)]
pub struct Ladder {
    /// All light samples, visibility traced at the pixel.
    pub samples_reference: Picture,
    /// BRDF refined, by growing cut.
    pub refined: Vec<Rung>,
    /// BRDF once a node, by growing cut.
    pub once: Vec<Rung>,
    /// Close-up at a small cut.
    pub detail: Detail,
}

/// The view of the ladder: small, for each pixel of the reference takes thousands of rays.
fn settings() -> PictureSettings {
    PictureSettings { environment: "studio".into(), size: [240, 180], aa: 1, ..Default::default() }
}

/// Renders, traces and compares.
///
/// # Errors
/// A folder that cannot be written, or Ctrl-C.
pub fn climb(dataset: &Arc<Dataset>, environments: &Environments, out: &Path, steps: &Steps) -> Result<Ladder> {
    let stage = Stage::new(dataset, environments, out);
    let subject = Subject::new(dataset.clone(), stage.view(&settings()), stage.light(&settings()));
    steps.begin("tracing the reference: every light sample from every pixel");
    let progress = steps.progress("reference", "pixels");
    let truth = Truth::trace(&subject, &progress)?;
    progress.finish();
    steps.check()?;
    let samples_reference =
        stage.keep("reference-samples", "ray-traced reference", settings(), &truth.image, truth.seconds)?;
    steps.begin("rendering at growing illumination cuts, and comparing");
    let refined = rungs(&stage, &subject, true, &truth, &progress)?;
    let once = rungs(&stage, &subject, false, &truth, &progress)?;
    steps.check()?;
    steps.begin("tracing the reference by paths: the continuous environment, close up");
    let detail = close_up(&stage, steps)?;
    Ok(Ladder { samples_reference, refined, once, detail })
}

fn rungs(stage: &Stage, subject: &Subject, refine: bool, truth: &Truth, progress: &dyn Progress) -> Result<Vec<Rung>> {
    let sampling = if refine { BrdfSampling::Refine } else { BrdfSampling::Once };
    let climbing = Settings { sizes: CUT_SIZES.into(), sampling, ..Settings::default() };
    let known = Some(truth.clone());
    let ladder = ladder::climb(subject, &climbing, &mut CpuBackend::new(), known, progress, &mut |_| Ok(()))?;
    let steps = ladder.ok_or(Interrupted)?.steps;
    steps.into_iter().map(|step| kept(stage, step, refine, truth)).collect()
}

/// Writes picture and error map of a step.
fn kept(stage: &Stage, Step { rung, metrics }: Step, refine: bool, truth: &Truth) -> Result<Rung> {
    let (size, way) = (rung.illum_cut, if refine { "refine" } else { "once" });
    let settings = PictureSettings { illum_cut: size, refine, ..settings() };
    let seconds = rung.stats.seconds;
    let picture = stage.keep(&format!("cut-{size}-{way}"), &format!("{size} nodes"), settings, &rung.image, seconds)?;
    let file = format!("error-{size}-{way}.png");
    error_map(&rung.image, &truth.image, ErrorMap::Relative, Some(MAP_TOP))?.image.write(&stage.out.join(&file))?;
    Ok(Rung { picture: Picture { stats: Some(rung.stats), ..picture }, metrics, error_map: file })
}

/// Glossy metal at a small cut, where refinement shows most.
fn close_up(stage: &Stage, steps: &Steps) -> Result<Detail> {
    let settings = PictureSettings { camera: "detail", illum_cut: 64, size: [360, 270], aa: 1, ..settings() };
    let once = PictureSettings { refine: false, ..settings.clone() };
    let (once, once_image) = stage.render("detail-once", "sampled once a node", once)?;
    let (refined, refined_image) = stage.render("detail-refine", "refined in the merge", settings.clone())?;
    let progress = steps.progress("reference", "passes");
    let start = Instant::now();
    let (view, light) = (stage.view(&settings), stage.light(&settings));
    let truth = stage.renderer.path_reference(&view, &light, &[], PathSettings::direct(PATH_SAMPLES), &progress);
    progress.finish();
    steps.check()?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Detail {
        once,
        refined,
        path_reference: stage.keep("reference-path", "path-traced reference", settings, &truth, seconds)?,
        metrics_once: compare(&once_image, &truth)?,
        metrics_refined: compare(&refined_image, &truth)?,
    })
}
