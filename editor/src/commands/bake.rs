//! `lapidary bake`.

use crate::{console::Console, outcome::Outcome};
use anyhow::Result;
use lapidary_precompute::cli::BakeArgs;

/// Bakes and says what came of it.
///
/// # Errors
/// See [`BakeArgs::run`].
pub fn run(args: &BakeArgs, console: Console) -> Result<Outcome> {
    let report = args.run(console.quiet)?;
    console.summary(format_args!(
        "{}: {} vertices, {:.0} nodes a cut, visibility RMS {:.3}, {:.1} MB, {:.1} s",
        args.output.display(),
        report.vertices,
        report.mean_cut,
        report.rms_visibility,
        report.bytes_total as f64 / 1e6,
        report.seconds.get("total").unwrap_or(&0.0),
    ))?;
    Ok(Outcome::Done)
}
