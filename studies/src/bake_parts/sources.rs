//! Surface sources, which gather one bounce.

use super::StudiedPart;
use crate::values::place;
use clap::Args;
use glam::Vec3;
use lapidary_core::{
    cut::SourceCriterion,
    dataset::{BakeReport, BakeSettings, IndirectReport, IndirectSettings, sigma_text},
};

/// The surface source part.
pub struct Sources;

/// Options of the surface source part.
#[derive(Args, Clone, Debug)]
pub struct SourceOptions {
    /// Number of surface sources: a power of two up to 32768 [default: from the preset]
    #[arg(long, value_name = "N")]
    sources: Option<usize>,
    /// Error bound of a cluster of sources: split while |C| var > sigma², in units of a source's share of the
    /// hemisphere; 0 to 1000, smaller is finer [default: 2]
    #[arg(long, value_name = "S")]
    source_sigma: Option<f32>,
    /// Bounced light is baked for the enclosed space around this point, in meters. Surfaces that light from there cannot reach get
    /// no sources [default: the space chosen from shots, cameras and lights, else the largest found]
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    viewpoint: Option<Vec3>,
}

impl SourceOptions {
    /// Applies the options to `settings`.
    pub fn apply(&self, settings: &mut BakeSettings) {
        let s = &mut settings.indirect;
        s.sources = self.sources.unwrap_or(s.sources);
        s.criterion.sigma = self.source_sigma.unwrap_or(s.criterion.sigma);
        s.viewpoint = self.viewpoint.or(s.viewpoint);
    }
}

impl StudiedPart for Sources {
    fn summary(&self, report: &BakeReport) -> Option<String> {
        let r = report.indirect.as_ref()?;
        let error = 100.0 * r.relative_error;
        Some(format!("{} sources, {:.0} nodes a cut, error {error:.1} %", r.sources, r.mean_cut))
    }

    fn info(&self, report: &BakeReport, settings: &BakeSettings) -> String {
        report.indirect.as_ref().map_or(String::new(), |report| info_text(report, &settings.indirect))
    }

    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings) {
        let (preset, wanted) = (draft.indirect, wanted.indirect);
        let sources = (preset.sources / 4).min(wanted.sources);
        let as_fine_as_wanted = wanted.criterion.sigma * (sources as f32 / wanted.sources as f32).sqrt();
        let criterion = SourceCriterion { sigma: preset.criterion.sigma.max(as_fine_as_wanted), ..preset.criterion };
        draft.indirect = IndirectSettings { sources, criterion, viewpoint: wanted.viewpoint };
    }

    fn is_sooner(&self, draft: &BakeSettings, wanted: &BakeSettings) -> bool {
        draft.indirect.sources < wanted.indirect.sources
    }
}

fn info_text(r: &IndirectReport, s: &IndirectSettings) -> String {
    let [x, y, z] = r.viewpoint;
    let without = if r.without_area > 0 { format!(" ({} of them on none)", r.without_area) } else { String::new() };
    let apart = if r.widest_spacing > r.radius {
        format!("{:.3} to {:.3}", r.radius, r.widest_spacing)
    } else {
        format!("{:.3}", r.radius)
    };
    let audit = match &r.audit {
        None => String::new(),
        Some(audit) if audit.leaves_per_probe == 1 => ", too fine for boundaries".into(),
        Some(audit) => format!(", {:.3} % of sources missed", 100.0 * audit.leaves_wrong),
    };
    format!(
        "sources    {} on {:.1} m²{without}, {apart} m apart, reached from {x:.2}, {y:.2}, {z:.2}\n\
         seen       {:.1} nodes on average, {} at most, sigma {}, {:.1} % error of solid angles, {:.1} MB{audit}\n",
        r.sources,
        r.area,
        r.mean_cut,
        r.max_cut,
        sigma_text(r.criterion(s.criterion).sigma, s.criterion.sigma),
        100.0 * r.relative_error,
        r.bytes_cuts as f64 / 1e6
    )
}
