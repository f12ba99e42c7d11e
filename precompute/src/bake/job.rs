//! The job of a bake: settings, output and options of the run.

use super::settings::ResolvedBake;
use lapidary_core::{animation::ClipTime, scene::pose::Poses};
use std::path::PathBuf;

/// The job of a bake: settings, output and options of the run.
#[derive(Clone, Debug)]
pub struct BakeJob {
    /// Settings that decide the result; see [`crate::resolve`].
    pub settings: ResolvedBake,
    /// Where objects are, relative to their file; deformed as they are at [`Self::clip_time`].
    pub poses: Poses,
    /// The time of an animation that the scene is at; `None` at rest.
    pub clip_time: Option<ClipTime>,
    /// Where the dataset goes; checkpoints lie beside it.
    pub output: PathBuf,
    /// Files that the scene was imported from, which the output must not be.
    pub inputs: Vec<PathBuf>,
    /// Number of chunks; `None` for a checkpoint every few seconds.
    pub chunks: Option<usize>,
    /// Resume from the checkpoint of an interrupted bake.
    pub resume: bool,
    /// Seconds that the import took, for the report.
    pub import_secs: f64,
    /// Warnings of the import, for the report.
    pub warnings: Vec<String>,
}

impl BakeJob {
    /// A bake from the beginning, without a report of the import.
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
