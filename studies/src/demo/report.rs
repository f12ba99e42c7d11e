//! All figures of the demonstration, written as `report.json`.

use super::{gallery::Gallery, ladder::Ladder};
use lapidary_core::dataset::{BakeReport, Dataset};
use lapidary_precompute::Verification;
use serde::Serialize;

/// All figures of the demonstration.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: &'static str,
    /// Number of threads.
    pub threads: usize,
    /// Total wall-clock seconds.
    pub seconds: f64,
    /// The report of the bake.
    pub bake: BakeReport,
    /// Result of retracing some vertices.
    pub verification: Verification,
    /// Gallery pictures.
    pub gallery: Gallery,
    /// Measured pictures.
    pub ladder: Ladder,
}

impl Report {
    /// Collects the results of all steps.
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
