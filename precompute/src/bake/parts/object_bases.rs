//! The part of the bases of objects.

use super::{PartBake, Put, within};
use crate::{
    bake::{clock::Clock, phases::bounces::Bouncing},
    errors::{BakeError, SettingsError},
    setting::Setting,
};
use lapidary_core::dataset::{BakeSettings, ObjectBasesSettings};

/// Functions of each object, for light that is solved anew after a move.
pub struct ObjectBasesBake;

impl PartBake for ObjectBasesBake {
    fn draft(&self, settings: &mut BakeSettings) {
        settings.object_bases = ObjectBasesSettings { functions: 30_000, levels: 5, sender_level: 3 };
    }

    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError> {
        let ObjectBasesSettings { functions, levels, sender_level } = settings.object_bases;
        within(&[
            (Setting::Functions, f64::from(functions), 1.0, 1e7),
            (Setting::ObjectLevels, levels as f64, 1.0, 8.0),
            (Setting::SenderLevel, sender_level as f64 + 1.0, 1.0, levels as f64),
        ])
    }

    fn memory(&self, _vertices: u64, settings: &BakeSettings, _threads: usize) -> u64 {
        const BYTES_PER_FUNCTION: u64 = 200; // point, owner, cells of its grid, parents
        const CANDIDATES: u64 = 16 * 36; // points that are tried for each that has room
        u64::from(settings.object_bases.functions) * (BYTES_PER_FUNCTION + CANDIDATES)
    }

    fn size(&self) -> Option<Setting> {
        Some(Setting::Functions)
    }

    fn bake(&self, bouncing: &Bouncing, clock: &mut Clock) -> Result<Put, BakeError> {
        let (bases, report) = bouncing.bake_object_bases(clock)?;
        Ok(Box::new(|dataset| {
            (dataset.object_bases, dataset.report.object_bases) = (Some(bases.into()), Some(report));
        }))
    }
}
