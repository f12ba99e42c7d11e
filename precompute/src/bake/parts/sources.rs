//! The part of surface sources.

use super::{PartBake, Put, buffers, cuts, environment::environment_nodes, within};
use crate::{
    bake::{clock::Clock, phases::bounces::Bouncing},
    errors::{BakeError, SettingsError},
    setting::Setting,
};
use lapidary_core::{bounds::MOST_COORDINATE, dataset::BakeSettings, light_tree::height_of};

/// Surface sources, and the vertices' cuts over them.
pub struct SourcesBake;

impl PartBake for SourcesBake {
    fn draft(&self, settings: &mut BakeSettings) {
        settings.indirect.sources = 8192;
    }

    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError> {
        let indirect = &settings.indirect;
        height_of(indirect.sources).map_err(|_| SettingsError::Sources(indirect.sources))?;
        let viewpoint = indirect.viewpoint.unwrap_or_default().to_array().map(f64::from);
        let farther = |a: f64, b: f64| if a.is_nan() || b.abs() <= a.abs() { a } else { b };
        let farthest = viewpoint.into_iter().fold(0.0, farther);
        within(&[
            (Setting::Viewpoint, farthest, -f64::from(MOST_COORDINATE), f64::from(MOST_COORDINATE)),
            (Setting::SourceSigma, f64::from(indirect.criterion.sigma), 0.0, 1e3),
            (Setting::SourceContrast, f64::from(indirect.criterion.contrast), 0.0, 1e3),
            (Setting::LargestSolidAngle, f64::from(indirect.criterion.max_solid_angle), 1e-4, 10.0),
        ])
    }

    fn memory(&self, vertices: u64, settings: &BakeSettings, threads: usize) -> u64 {
        let sources = settings.indirect.sources as u64;
        let own = if settings.mode.environment() { cuts(sources, environment_nodes(settings)) } else { 0 };
        cuts(vertices, source_nodes(settings)) + buffers(sources, settings, threads) + own
    }

    fn bake(&self, bouncing: &Bouncing, clock: &mut Clock) -> Result<Put, BakeError> {
        let (bake, report) = bouncing.bake_indirect(clock)?;
        Ok(Box::new(|dataset| (dataset.indirect, dataset.report.indirect) = (Some(bake), Some(report))))
    }
}

/// Mean nodes in the scene with the longest cuts, for 32,768 sources at sigma 2. Other scenes have 500 and more. Finer bounds give
/// longer cuts.
fn source_nodes(settings: &BakeSettings) -> u64 {
    let finer = (2.0 / settings.indirect.criterion.sigma.max(1e-3)).max(1.0);
    ((1340.0 * finer) as u64).min(settings.indirect.sources as u64)
}
