//! The job of a bake: settings, output and options of the run.

use super::settings::ResolvedBake;
use lapidary_core::{animation::ClipTime, scene::pose::Poses};
use std::path::PathBuf;

/// The job of a bake: settings, output and options of the run.
#[derive(Clone, Debug)]
pub struct BakeJob {
    /// Settings that decide the result; see [`crate::resolve`].
    pub settings: ResolvedBake,
    /// Poses of objects, relative to their file; deformed as at [`Self::clip_time`].
    pub poses: Poses,
    /// The scene's time in an animation; `None` at rest.
    pub clip_time: Option<ClipTime>,
    /// Output path; checkpoints are stored beside it.
    pub output: PathBuf,
    /// Files of the imported scene, which the output must not overwrite.
    pub inputs: Vec<PathBuf>,
    /// Number of chunks; `None` stores a checkpoint every few seconds.
    pub chunks: Option<usize>,
    /// Resume from the checkpoint of an interrupted bake.
    pub resume: bool,
    /// Import time in seconds, for the report.
    pub import_secs: f64,
    /// Warnings of the import, for the report.
    pub warnings: Vec<String>,
}

impl BakeJob {
    /// A new bake without a report of the import.
    pub fn new(settings: ResolvedBake, output: PathBuf) -> Self {
        Self {
            settings,
            poses: Poses::default(),
            clip_time: None,
            output,
            inputs: Vec::new(),
            chunks: None,
            resume: false,
            import_secs: 0.0,
            warnings: Vec::new(),
        }
    }
}
