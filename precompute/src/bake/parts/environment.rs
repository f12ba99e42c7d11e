//! The part of distant light. Every bake has its phases.

use super::{PartBake, buffers, cuts, within};
use crate::{errors::SettingsError, setting::Setting};
use lapidary_core::{cut::CutCriterion, dataset::BakeSettings, light_tree::height_of};

/// Visibility of distant light.
pub struct EnvironmentBake;

impl PartBake for EnvironmentBake {
    fn draft(&self, settings: &mut BakeSettings) {
        // Eq. 5 bounds |C| var: a quarter of the lights at half the sigma has the same error in solid angle.
        settings.lights = 8192;
        settings.criterion = CutCriterion { sigma: 1.5, ..CutCriterion::default() };
    }

    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError> {
        height_of(settings.lights)?;
        let criterion = &settings.criterion;
        within(&[
            (Setting::Beta, f64::from(settings.beta), 0.0, 1.0),
            (Setting::Sigma, f64::from(criterion.sigma), 0.0, 1e3),
            (Setting::MaxCut, f64::from(criterion.max_nodes), 1.0, f64::from(u32::MAX)),
            (Setting::TotalError, criterion.total_error.map_or(0.0, f64::from), 0.0, 1e3),
            (Setting::MaxBytes, settings.max_bytes.map_or(1024.0, |bytes| bytes as f64), 1024.0, 1e12),
        ])
    }

    fn memory(&self, vertices: u64, settings: &BakeSettings, threads: usize) -> u64 {
        cuts(vertices, environment_nodes(settings)) + buffers(settings.lights as u64, settings, threads)
    }
}

/// Nodes of a cut over the environment: twice the mean of real scenes.
pub fn environment_nodes(settings: &BakeSettings) -> u64 {
    (settings.lights as u64).min(u64::from(settings.criterion.max_nodes)).min(400)
}
