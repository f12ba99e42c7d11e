//! `lapidary bench --against OTHER`: times of this program and another one on the bundled scenes. Both run alternately on the same
//! machine, so their ratio shows the effect of a change on any machine.

mod first_picture;
mod jobs;
mod measure;
pub(super) mod program;
mod report;
mod runs;
mod xwd;

use super::{JsonArgs, PASSES, PICTURE};
use crate::{
    bundled::DataFolder,
    outputs::CommandFiles,
    terminal::{Console, Outcome, Steps},
    values,
};
use anyhow::{Context, Result};
use clap::Args;
use measure::{Contest, Limits};
use program::Program;
use report::Report;
use std::{path::PathBuf, time::Instant};

/// Options of the comparison.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Comparison with another program on the bundled scenes")]
pub struct AgainstArgs {
    /// Measure this program and another build of it alternately on the bundled scenes, instead of a dataset's frames
    #[arg(
        long,
        value_name = "PROGRAM",
        conflicts_with_all = PICTURE,
        conflicts_with_all = PASSES,
        conflicts_with_all = ["file", "surfels"]
    )]
    against: Option<PathBuf>,
    /// Exit with code 3 if this program takes more than this multiple of the other one's time in any row
    #[arg(long, value_name = "RATIO", requires = "against", conflicts_with = "file", value_parser = values::positive)]
    fail_above: Option<f32>,
}

impl AgainstArgs {
    /// Files that it reads.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().reads(&self.against)
    }
}

/// Measures and prints.
///
/// # Errors
/// A file that is not this program, missing bundled data, an unwritable report, or Ctrl-C.
pub fn run(args: &AgainstArgs, data: &DataFolder, json: &JsonArgs, console: Console) -> Result<Outcome> {
    let against = args.against.as_deref().context("without a dataset, name a program with --against")?;
    let this = Program::open(&std::env::current_exe().context("cannot find this program's own file")?)?;
    let other = Program::open(against)?;
    let steps = Steps::new(console);
    let start = Instant::now();
    let rows = Contest::new([&this, &other], data, Limits::USUAL, &steps)?.measure(jobs::JOBS)?;
    let report = Report::new([&this, &other], rows, start.elapsed(), args.fail_above);
    json.tell(&report, || report.table())?;
    Ok(report.outcome())
}
