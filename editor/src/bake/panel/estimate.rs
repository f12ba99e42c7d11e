//! Estimates the cost of a bake from the last one.

use super::BakeContext;
use crate::bake::parts::{self, Cost};
use lapidary_core::dataset::{BakeReport, BakeSettings};
use lapidary_precompute::{BounceTrial, POINTS_PER_VERTEX, Stored, Trial, most_vertices};

/// Core seconds per vertex, where no trial has measured them: placing vertices where visibility varies, and all else before the
/// light tree.
const TESSELLATION: [f64; 2] = [1.4e-4, 5e-5];
/// Bytes of a packed node.
pub const NODE_BYTES: f64 = 2.0;

/// Size of a scene before tessellation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneStats {
    /// Its vertices.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
}

/// Input of estimates: the last bake goes before a trial, and a trial before averages.
#[derive(Clone, Copy, Debug)]
pub struct Speed<'a> {
    /// Vertices before tessellation.
    pub source_vertices: Option<usize>,
    /// Report and settings of the last bake.
    pub last: Option<(&'a BakeReport, &'a BakeSettings)>,
    /// Result of a trial.
    pub trial: Option<Trial>,
    /// Result of a trial of the bounces.
    pub bounces: Option<BounceTrial>,
    /// Cores that a bake may use, 1 or more.
    pub cores: usize,
}

/// Rough cost of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Vertices after tessellation, at most.
    pub vertices: usize,
    /// Seconds.
    pub secs: f64,
    /// Bytes of the cuts.
    pub bytes: u64,
}

impl<'a> Speed<'a> {
    /// From the panel's input.
    pub fn known(context: &BakeContext<'a>) -> Self {
        Self {
            source_vertices: context.source_vertices(),
            last: context.dataset.map(|dataset| (&dataset.report, &dataset.settings)),
            trial: context.trial,
            bounces: context.bounce_trial,
            cores: context.cores.max(1),
        }
    }

    /// Estimated cost of a bake with `settings`; `None` if its number of vertices is unknown.
    pub fn estimate(&self, settings: &BakeSettings) -> Option<Estimate> {
        self.source_vertices.max(settings.max_vertices)?;
        let vertices = most_vertices(self.source_vertices.unwrap_or(0), settings);
        let cost = |part| parts::of(part).cost(self, settings, vertices as f64);
        let costs: Vec<Cost> = settings.mode.parts().map(cost).collect();
        let bytes = costs.iter().map(|cost| cost.bytes as u64).sum();
        let secs = self.tessellation(settings, vertices as f64) + costs.iter().map(|cost| cost.secs).sum::<f64>();
        Some(Estimate { vertices, secs, bytes })
    }

    /// Seconds until the vertices are placed.
    fn tessellation(&self, settings: &BakeSettings, vertices: f64) -> f64 {
        let of_trial = |trial: Trial| POINTS_PER_VERTEX as f64 * trial.core_secs_per_split;
        let splits = Stored::of(settings.mode).is_some() && settings.max_vertices > self.source_vertices;
        let placed = if splits { self.trial.map_or(TESSELLATION[0], of_trial) } else { 0.0 };
        vertices * (placed + TESSELLATION[1]) / self.cores as f64
    }
}

/// Input for a scene of 5,000 vertices on two cores.
#[cfg(test)]
pub fn test_speed(report: Option<&BakeReport>) -> Speed<'_> {
    static SETTINGS: std::sync::LazyLock<BakeSettings> = std::sync::LazyLock::new(BakeSettings::default);
    let last = report.map(|report| (report, &*SETTINGS));
    Speed { source_vertices: Some(5000), last, trial: None, bounces: None, cores: 2 }
}

#[cfg(test)]
mod tests {
    use super::{test_speed as speed, *};
    use lapidary_core::dataset::BakeParts;
    use lapidary_precompute::{BasisTrial, Preset, SourcesTrial};

    #[test]
    fn a_trial_of_the_bounces_tells_what_they_take() {
        let sources = SourcesTrial {
            sources: 1024,
            core_secs_per_source: 6e-4,
            core_secs_per_point: 3e-4,
            mean_cut: (85.0, 2.0),
        };
        let basis = BasisTrial { functions: 1276, core_secs_per_gather_ray: 2e-6 };
        let trial = BounceTrial { sources, basis };
        let of = |mode, bounces| {
            let speed = Speed { bounces, ..speed(None) };
            let settings = BakeSettings { mode, max_vertices: None, ..Preset::Normal.settings() };
            speed.estimate(&settings).unwrap().secs - 5000.0 * 5e-5 / 2.0
        };
        let sources = 1e4 * 3e-4 * 32_f64.powf(0.3) / 2.0 + 32_768.0 * 6e-4 / 2.0;
        assert!((of(BakeParts::INDIRECT, Some(trial)) - sources).abs() < 1e-6);
        let gathered = 1276.0 * (13.3 + 2.0 * 16.3) * 512.0 * 2e-6 * 1.25 / 2.0;
        assert!((of(BakeParts::MESHLESS, Some(trial)) - gathered).abs() < 1e-6);
        assert!((of(BakeParts::MESHLESS, None) - 55.0).abs() < 1e-6, "the average without one");
    }

    #[test]
    fn limits_hold_and_an_unknown_scene_has_no_estimate() {
        let settings = BakeSettings { max_bytes: Some(4096), ..Preset::High.settings() };
        assert_eq!(speed(None).estimate(&settings).unwrap().bytes, 4096);
        let unlimited = BakeSettings { max_vertices: None, ..Preset::High.settings() };
        assert_eq!(Speed { source_vertices: None, ..speed(None) }.estimate(&unlimited), None);
    }

    #[test]
    fn both_cost_what_their_parts_cost() {
        let settings = Preset::Normal.settings();
        let cost = |mode| speed(None).estimate(&BakeSettings { mode, ..settings.clone() }).unwrap();
        let parts = [BakeParts::CUTS, BakeParts::MESHLESS].map(cost);
        let all = cost(BakeParts::ALL);
        // Vertices are placed once, and a basis asks for none.
        let (placed, long_edges) = (1e5 * 1.9e-4 / 2.0, 1e5 * 5e-5 / 2.0);
        assert!((all.secs + long_edges - parts.iter().map(|p| p.secs).sum::<f64>()).abs() < 1e-6);
        assert!(all.bytes.abs_diff(parts.iter().map(|p| p.bytes).sum()) < 4);
        assert!(parts.iter().all(|part| part.secs < all.secs && part.bytes < all.bytes && part.bytes > 0));
        let [environment, indirect] = [BakeParts::ENVIRONMENT, BakeParts::INDIRECT].map(cost);
        let on_sources = 32_768.0 * 32_768.0 / 90e6;
        assert!(
            (parts[0].secs + placed - environment.secs - indirect.secs - on_sources).abs() < 1e-6,
            "sources see the sky too"
        );
    }
}
