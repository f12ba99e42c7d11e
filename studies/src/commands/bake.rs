//! `lapidary bake`.

mod args;

pub use args::BakeArgs;

use crate::terminal::{Console, Outcome};
use anyhow::Result;
use lapidary_core::dataset::BakeReport;
use std::path::Path;

/// Bakes and says what came of it.
///
/// # Errors
/// See [`BakeArgs::run`].
pub fn run(args: &BakeArgs, console: Console) -> Result<Outcome> {
    let report = args.run(console.quiet)?;
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

/// Says what came of a bake or a merge.
pub(super) fn summarize(report: &BakeReport, output: &Path, console: Console) -> Result<()> {
    console.summary(format_args!(
        "{}: {} vertices, {}, {:.1} MB, {:.1} s",
        output.display(),
        report.vertices,
        parts(report).join("; "),
        report.bytes_total as f64 / 1e6,
        report.seconds("total").unwrap_or(0.0),
    ))
}

/// What was baked, with how fine it is.
fn parts(report: &BakeReport) -> Vec<String> {
    let mut parts = Vec::new();
    if report.mode.environment() {
        parts.push(format!("{:.0} nodes a cut, visibility RMS {:.3}", report.mean_cut, report.rms_visibility));
    }
    if let Some(indirect) = &report.indirect {
        let error = 100.0 * indirect.relative_error;
        parts.push(format!("{} sources, {:.0} nodes a cut, error {error:.1} %", indirect.sources, indirect.mean_cut));
    }
    if let Some(meshless) = &report.meshless {
        parts.push(format!("{} basis functions", meshless.functions.iter().sum::<usize>()));
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::dataset::{BakeParts, IndirectReport};

    #[test]
    fn the_summary_tells_only_what_was_baked() {
        let environment = BakeReport { mean_cut: 170.0, ..Default::default() };
        assert_eq!(parts(&environment), ["170 nodes a cut, visibility RMS 0.000"]);
        let sources = IndirectReport { sources: 512, mean_cut: 87.0, relative_error: 0.05, ..Default::default() };
        let bounces = BakeReport { mode: BakeParts::INDIRECT, indirect: Some(sources), ..environment };
        assert_eq!(parts(&bounces), ["512 sources, 87 nodes a cut, error 5.0 %"]);
    }
}
