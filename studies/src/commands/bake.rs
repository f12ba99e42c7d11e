//! `lapidary bake`.

mod args;

pub use args::BakeArgs;

use crate::{
    bake_parts,
    terminal::{Console, Outcome},
};
use anyhow::Result;
use lapidary_core::dataset::BakeReport;
use std::path::Path;

/// Bakes and reports the result.
///
/// # Errors
/// See [`BakeArgs::run`].
pub fn run(args: &BakeArgs, console: Console) -> Result<Outcome> {
    let report = args.run(console)?;
    if let Some(shard) = args.shard {
        console.summary(format_args!(
            "{}: share {shard} is complete, {:.1} s; when all are, run: lapidary merge {}",
            shard.folder_of(&args.output).display(),
            report.seconds("total").unwrap_or(0.0),
            args.output.display(),
        ))?;
        return Ok(Outcome::Done);
    }
    summarize(&report, &args.output, console)?;
    Ok(Outcome::Done)
}

/// Reports the result of a bake or a merge.
pub(super) fn summarize(report: &BakeReport, output: &Path, console: Console) -> Result<()> {
    let parts: Vec<String> = bake_parts::all().filter_map(|part| part.summary(report)).collect();
    console.summary(format_args!(
        "{}: {} vertices, {}, {:.1} MB, {:.1} s",
        output.display(),
        report.vertices,
        parts.join("; "),
        report.bytes_total as f64 / 1e6,
        report.seconds("total").unwrap_or(0.0),
    ))
}
