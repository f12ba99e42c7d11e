//! The part of the meshless basis.

use super::{PartBake, Put, within};
use crate::{
    bake::{clock::Clock, phases::bounces::Bouncing},
    errors::{BakeError, SettingsError},
    meshless::points::check_coarse_radius,
    setting::Setting,
};
use lapidary_core::dataset::{BakeSettings, MeshlessSettings};

/// The meshless basis and its transport operator.
pub struct BasisBake;

impl PartBake for BasisBake {
    fn draft(&self, settings: &mut BakeSettings) {
        settings.meshless = MeshlessSettings { levels: 4, sender_levels: 3, rays: 256, ..settings.meshless };
    }

    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError> {
        let MeshlessSettings { levels, sender_levels, coarse_radius, rays, epsilon } = settings.meshless;
        within(&[
            (Setting::Levels, levels as f64, 1.0, 8.0),
            (Setting::SenderLevels, sender_levels as f64, 1.0, levels as f64),
            (Setting::GatherRays, rays as f64, 16.0, 65_536.0),
            (Setting::Epsilon, f64::from(epsilon), 0.0, 1.0),
            (Setting::CoarseRadius, coarse_radius.map_or(1.0, f64::from), 1e-6, 1e9),
        ])
    }

    fn check_scene(&self, settings: &BakeSettings, diagonal: f32) -> Result<(), BakeError> {
        Ok(check_coarse_radius(&settings.meshless, diagonal)?)
    }

    /// Each level has four times as many functions as the one before.
    fn memory(&self, _vertices: u64, settings: &BakeSettings, _threads: usize) -> u64 {
        const BYTES_PER_FUNCTION: u64 = 150; // point, place in its tree, row of links
        const LINKS_PER_FUNCTION: u64 = 20; // 9 to 40 in real scenes, fewer with more levels
        const BYTES_PER_LINK: u64 = 24; // 16 in rows while baking, 8 packed
        settings.meshless.expected_functions() * (BYTES_PER_FUNCTION + LINKS_PER_FUNCTION * BYTES_PER_LINK)
    }

    fn size(&self) -> Option<Setting> {
        Some(Setting::Levels)
    }

    fn bake(&self, bouncing: &Bouncing, clock: &mut Clock) -> Result<Put, BakeError> {
        let (bake, report) = bouncing.bake_meshless(clock)?;
        Ok(Box::new(|dataset| (dataset.meshless, dataset.report.meshless) = (Some(bake.into()), Some(report))))
    }
}
