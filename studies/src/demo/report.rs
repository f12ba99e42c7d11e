//! Every figure of the demonstration; `report.json` is this.

use super::{gallery::Gallery, ladder::Ladder};
use lapidary_core::dataset::{BakeReport, Dataset};
use lapidary_precompute::Verification;
use serde::Serialize;

/// Every figure of the demonstration.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: &'static str,
    /// Threads that worked.
    pub threads: usize,
    /// Wall-clock seconds in all.
    pub seconds: f64,
    /// The report of the bake.
    pub bake: BakeReport,
    /// What tracing some vertices again gave.
    pub verification: Verification,
    /// Pictures to look at.
    pub gallery: Gallery,
    /// Pictures to measure.
    pub ladder: Ladder,
}

impl Report {
    /// Collects what the steps gave.
    pub fn new(dataset: &Dataset, verification: Verification, gallery: Gallery, ladder: Ladder, seconds: f64) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            seconds,
            bake: dataset.report.clone(),
            verification,
            gallery,
            ladder,
        }
    }
}
