//! The `merge` command.

use super::bake::summarize;
use crate::{
    outputs::CommandFiles,
    terminal::{Console, Outcome, ProgressReporter, ProgressStyle},
};
use anyhow::Result;
use clap::Args;
use lapidary_core::dataset::BakeReport;
use lapidary_interchange::image;
use lapidary_precompute::merge;
use std::path::PathBuf;

/// Options of `merge`.
#[derive(Args, Clone, Debug)]
pub struct MergeArgs {
    /// Dataset to write; the shares must be beside it
    #[arg(value_name = "FILE.cuts")]
    pub file: PathBuf,
    /// How progress is shown on standard error
    #[arg(long, value_enum, default_value_t)]
    pub progress: ProgressStyle,
}

impl MergeArgs {
    /// Files that it writes.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().writes([&self.file])
    }

    /// Merges, with progress on standard error.
    ///
    /// # Errors
    /// Missing, incomplete or unrelated shares, or an unwritable output.
    pub fn run(&self, console: Console) -> Result<BakeReport> {
        let progress = ProgressReporter::new(self.progress, console);
        progress.cancel_on_interrupt();
        let report = merge(&self.file, image::decode, &progress)?.report;
        progress.finish();
        Ok(report)
    }
}

/// Merges and reports the result.
///
/// # Errors
/// See [`MergeArgs::run`].
pub fn run(args: &MergeArgs, console: Console) -> Result<Outcome> {
    summarize(&args.run(console)?, &args.file, console)?;
    Ok(Outcome::Done)
}
