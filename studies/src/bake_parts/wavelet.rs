//! Wavelet transport.

use super::StudiedPart;
use clap::Args;
use lapidary_core::dataset::{BakeReport, BakeSettings};

/// The part of wavelet transport.
pub struct Wavelet;

/// Options of wavelet transport.
#[derive(Args, Clone, Debug)]
pub struct WaveletOptions {
    /// Coefficients of wavelet transport up to this are left out, 1e-6 to 1; smaller is finer [default: from the preset: 1e-4, draft
    /// 1e-3]
    #[arg(long, value_name = "T")]
    tau: Option<f32>,
}

impl WaveletOptions {
    /// Applies the options to `settings`.
    pub fn apply(&self, settings: &mut BakeSettings) {
        settings.wavelet.compression = self.tau.unwrap_or(settings.wavelet.compression);
    }
}

impl StudiedPart for Wavelet {
    fn summary(&self, report: &BakeReport) -> Option<String> {
        report.wavelet.as_ref().map(|r| format!("wavelet transport between {} quads", r.patches))
    }

    fn info(&self, report: &BakeReport, settings: &BakeSettings) -> String {
        report.wavelet.as_ref().map_or(String::new(), |r| {
            format!(
                "wavelet    {} functions on {} quads; {} coefficients of one bounce, {} of all beyond {:e}; {:.1} MB\n",
                r.functions,
                r.patches,
                r.direct,
                r.global,
                settings.wavelet.compression,
                r.bytes as f64 / 1e6
            )
        })
    }

    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings) {
        draft.wavelet.compression = draft.wavelet.compression.max(wanted.wavelet.compression);
    }

    /// Refinement takes most of the time, and is as fine in a draft.
    fn is_sooner(&self, _draft: &BakeSettings, _wanted: &BakeSettings) -> bool {
        false
    }

    /// A ground is split and is no quad.
    fn suits_a_ground(&self) -> bool {
        false
    }
}
