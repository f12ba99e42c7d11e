//! The ladder: one picture at growing illumination cuts, with the BRDF once and refined, against ray tracing.

use super::{
    data::Environments,
    stage::{Picture, PictureSettings, Stage},
    steps::Steps,
};
use anyhow::Result;
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_render::{
    PathSettings,
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
    steps.begin("tracing the reference: every light sample from every pixel");
    let (samples_reference, truth) = trace_samples(&stage, steps)?;
    steps.begin("rendering at growing illumination cuts, and comparing");
    let refined = rungs(&stage, true, &truth)?;
    let once = rungs(&stage, false, &truth)?;
    steps.check()?;
    steps.begin("tracing the reference by paths: the continuous environment, close up");
    let detail = close_up(&stage, steps)?;
    Ok(Ladder { samples_reference, refined, once, detail })
}

fn trace_samples(stage: &Stage, steps: &Steps) -> Result<(Picture, Image)> {
    let settings = settings();
    let progress = steps.progress("reference", "pixels");
    let start = Instant::now();
    let image = stage.renderer.samples_reference(&stage.view(&settings), &stage.light(&settings), &progress);
    progress.finish();
    steps.check()?;
    let seconds = start.elapsed().as_secs_f64();
    Ok((stage.keep("reference-samples", "ray-traced reference", settings, &image, seconds)?, image))
}

fn rungs(stage: &Stage, refine: bool, truth: &Image) -> Result<Vec<Rung>> {
    CUT_SIZES.iter().map(|&size| rung(stage, size, refine, truth)).collect()
}

fn rung(stage: &Stage, illum_cut: u32, refine: bool, truth: &Image) -> Result<Rung> {
    let way = if refine { "refine" } else { "once" };
    let settings = PictureSettings { illum_cut, refine, ..settings() };
    let (picture, image) = stage.render(&format!("cut-{illum_cut}-{way}"), &format!("{illum_cut} nodes"), settings)?;
    let error_map_file = format!("error-{illum_cut}-{way}.png");
    error_map(&image, truth, ErrorMap::Relative, Some(MAP_TOP))?.image.write(&stage.out.join(&error_map_file))?;
    Ok(Rung { picture, metrics: compare(&image, truth)?, error_map: error_map_file })
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
