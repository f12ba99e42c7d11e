//! The bake of the still life, sized to keep the demonstration under two minutes.

use crate::{bundled::DataFolder, terminal::Steps};
use anyhow::Result;
use lapidary_core::dataset::{BakeSettings, Dataset};
use lapidary_interchange::import::{Imported, import};
use lapidary_precompute::{BakeError, BakeJob, Preset, bake, resolve};
use std::{path::Path, time::Instant};

/// The baked still life.
pub const DATASET: &str = "still-life.cuts";

/// Most vertices: the scene's own plus some for shadows on the backdrop.
const MAX_VERTICES: usize = 60_000;

/// Imports and bakes into the output folder; resumes an interrupted bake.
///
/// # Errors
/// Unreadable data, an unwritable folder, or Ctrl-C.
pub fn bake_still_life(data: &DataFolder, out: &Path, steps: &Steps) -> Result<Dataset> {
    steps.begin("baking the still life: visibility of every light sample from every vertex");
    let start = Instant::now();
    let Imported { scene, report } = import(&data.still_life())?;
    let settings = resolve(BakeSettings { max_vertices: Some(MAX_VERTICES), ..Preset::Draft.settings() })?;
    let job = BakeJob {
        inputs: report.files,
        resume: true,
        import_secs: start.elapsed().as_secs_f64(),
        warnings: report.warnings,
        ..BakeJob::new(settings, out.join(DATASET))
    };
    let dataset = match bake(scene.clone(), &job, &steps.reporter) {
        // The checkpoint belongs to an older version or other data.
        Err(BakeError::Checkpoint(_)) => bake(scene, &BakeJob { resume: false, ..job }, &steps.reporter)?,
        result => result?,
    };
    steps.reporter.finish();
    Ok(dataset)
}
