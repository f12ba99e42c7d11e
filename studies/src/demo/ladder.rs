//! The ladder of the still life with the BRDF sampled once, refined, and with lit cuts, and a close-up against light paths.

use super::pictures::{Picture, StillLife};
use crate::{
    ladder::{self, Cuts, Settings, Step, Truth},
    terminal::{Interrupted, Steps},
};
use anyhow::Result;
use lapidary_interchange::image;
use lapidary_render::{
    BrdfSampling, Look, PathSettings, Progress,
    compare::{
        Metrics, compare,
        map::{ErrorMap, error_map},
    },
};
use serde::Serialize;
use std::time::Instant;

/// Sizes of the illumination cut.
pub const CUT_SIZES: [u32; 5] = [32, 64, 128, 256, 512];

/// Error at the upper end of all maps, which makes them comparable.
pub const MAP_TOP: f32 = 0.5;

/// Samples per pixel of the path-traced reference.
pub const PATH_SAMPLES: u32 = 64;

/// One picture of some cuts.
#[derive(Clone, Debug, Serialize)]
pub struct Rung {
    /// The picture.
    pub picture: Picture,
    /// Its differences from the samples reference.
    pub metrics: Metrics,
    /// File of the map of relative error.
    pub error_map: String,
}

/// Close-up pictures of the knot and the vase.
#[derive(Clone, Debug, Serialize)]
pub struct Detail {
    /// BRDF once per node.
    pub once: Picture,
    /// BRDF refined.
    pub refined: Picture,
    /// Path-traced reference.
    pub path_reference: Picture,
    /// Errors of `once`.
    pub metrics_once: Metrics,
    /// Errors of `refined`.
    pub metrics_refined: Metrics,
}

/// All rungs and their references.
#[derive(Clone, Debug, Serialize)]
pub struct Ladder {
    /// All light samples, visibility traced at the pixel.
    pub samples_reference: Picture,
    /// BRDF refined, by growing cut.
    pub refined: Vec<Rung>,
    /// BRDF once per node, by growing cut.
    pub once: Vec<Rung>,
    /// Lit cuts.
    pub lit: Rung,
    /// Close-up at a small cut.
    pub detail: Detail,
}

/// Renders, traces and compares.
///
/// # Errors
/// An unwritable folder, or Ctrl-C.
pub fn climb(still_life: &mut StillLife, steps: &Steps) -> Result<Ladder> {
    // Small, because each pixel of the reference takes thousands of rays.
    let look = still_life.look("main", "studio", [240, 180]);
    steps.begin("tracing the reference: every light sample from every pixel");
    let progress = steps.progress("reference", "pixels");
    let truth = Truth::trace(still_life.scene.baked(), &look, &progress)?;
    progress.finish();
    steps.check()?;
    let samples_reference =
        still_life.keep("reference-samples", "ray-traced reference", &look, &truth.image, truth.seconds)?;
    steps.begin("rendering at growing illumination cuts, and comparing");
    let refined = rungs(still_life, &look, CUT_SIZES.map(Cuts::Refine), &truth, &progress)?.into();
    let once = rungs(still_life, &look, CUT_SIZES.map(Cuts::Once), &truth, &progress)?.into();
    let [lit] = rungs(still_life, &look, [Cuts::Lit(look.tau)], &truth, &progress)?;
    steps.check()?;
    steps.begin("tracing the reference by paths: the continuous environment, close up");
    let detail = close_up(still_life, steps)?;
    Ok(Ladder { samples_reference, refined, once, lit, detail })
}

fn rungs<const N: usize>(
    still_life: &mut StillLife,
    look: &Look,
    cuts: [Cuts; N],
    truth: &Truth,
    progress: &dyn Progress,
) -> Result<[Rung; N]> {
    let climbing = Settings { cuts: cuts.into(), frames: 1 };
    let known = Some(truth.clone());
    let ladder = ladder::climb(&mut still_life.scene, look, &climbing, known, progress, &mut |_| Ok(()))?;
    let steps = ladder.ok_or(Interrupted)?.steps.into_iter();
    let rungs: Vec<Rung> = steps.map(|step| kept(still_life, look, step, truth)).collect::<Result<_>>()?;
    Ok(rungs.try_into().expect("a ladder has one step for each of the cuts"))
}

/// Writes the picture and error map of a step.
fn kept(still_life: &StillLife, look: &Look, Step { rung, metrics }: Step, truth: &Truth) -> Result<Rung> {
    let stem = match rung.cuts {
        Cuts::Once(size) => format!("{size}-once"),
        Cuts::Refine(size) => format!("{size}-refine"),
        Cuts::Lit(_) => "lit".into(),
    };
    let (name, look) = (format!("cut-{stem}"), rung.cuts.shown(look));
    let picture = still_life.keep(&name, &rung.cuts.label(), &look, &rung.image, rung.stats.seconds)?;
    let file = format!("error-{stem}.png");
    let map = error_map(&rung.image, &truth.image, ErrorMap::Relative, Some(MAP_TOP))?;
    image::write(&map.image, &still_life.out.join(&file))?;
    Ok(Rung { picture: Picture { stats: Some(rung.stats), ..picture }, metrics, error_map: file })
}

/// Glossy metal at a small cut, where refinement shows most.
fn close_up(still_life: &mut StillLife, steps: &Steps) -> Result<Detail> {
    let look = Cuts::Refine(64).shown(&still_life.look("detail", "studio", [360, 270]));
    let once = Look { sampling: BrdfSampling::Once, ..look.clone() };
    let (once, once_image) = still_life.render("detail-once", "sampled once per node", &once)?;
    let (refined, refined_image) = still_life.render("detail-refine", "refined in the merge", &look)?;
    let progress = steps.progress("reference", "passes");
    let start = Instant::now();
    let renderer = still_life.renderer(&look);
    let truth =
        renderer.path_reference(&look.view, &look.illumination, &[], PathSettings::direct(PATH_SAMPLES), &progress);
    progress.finish();
    steps.check()?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Detail {
        once,
        refined,
        path_reference: still_life.keep("reference-path", "path-traced reference", &look, &truth, seconds)?,
        metrics_once: compare(&once_image, &truth)?,
        metrics_refined: compare(&refined_image, &truth)?,
    })
}
