//! Wavelet transport.

use super::{Cost, PartOfPanel, Row, Step, bake_row, count, used};
use crate::{
    actions::Action,
    bake::panel::Speed,
    widgets::{
        entries::{Decades, decades_row},
        units::bytes,
    },
};
use egui::Ui;
use lapidary_core::dataset::{BakeParts, BakeReport, BakeSettings, WaveletSettings};
use lapidary_precompute::Phase;

/// Core seconds, bytes and quads of the maze. All grows with the pairs of quads.
const OF_THE_MAZE: (f64, f64, f64) = (20.0, 76e6, 59.0);

/// The entry.
pub struct Wavelet;

impl PartOfPanel for Wavelet {
    fn controls(&self, ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
        let help =
            "Leaves out how light goes from quad to quad below this. Smaller is more accurate and takes more memory.";
        let default = f64::from(WaveletSettings::default().compression);
        let tau = Decades { decimals: 6, ..Decades::count("Wavelet threshold", help, 1e-6..=1.0, default) };
        bake_row(actions, "Wavelet threshold", bake, |b| decades_row(ui, &tau, &mut b.wavelet.compression));
    }

    fn described(&self, settings: &BakeSettings) -> Vec<Row> {
        let WaveletSettings { compression } = settings.wavelet;
        vec![("Wavelet threshold", used(settings.mode.wavelet(), compression.to_string()))]
    }

    fn steps(&self, _mode: BakeParts) -> Vec<Step> {
        vec![(Phase::Wavelet, "Wavelet transport", "Following light from quad to quad, by direction.")]
    }

    /// A quad has four vertices of its own.
    fn cost(&self, speed: &Speed, _settings: &BakeSettings, _vertices: f64) -> Cost {
        let (core_secs, bytes, quads) = OF_THE_MAZE;
        let pairs = speed.source_vertices.map_or(1.0, |vertices| (vertices as f64 / 4.0 / quads).powi(2));
        Cost { secs: pairs * core_secs / speed.cores as f64, bytes: pairs * bytes }
    }

    fn rows(&self, report: &BakeReport, _settings: &BakeSettings) -> Vec<Row> {
        let Some(report) = &report.wavelet else { return Vec::new() };
        let coefficients = count(report.direct + report.global);
        vec![
            ("Quads", count(report.patches)),
            ("Wavelet coefficients", format!("{coefficients} ({})", bytes(report.bytes))),
        ]
    }
}
