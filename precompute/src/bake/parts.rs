//! The parts of a bake: settings, memory, work and verification. To add a part, add a file beside these and its line in [`part`].

mod environment;
mod meshless;
mod object_bases;
mod sources;
pub mod wavelet;

use super::{clock::Clock, phases::bounces::Bouncing};
use crate::{
    errors::{BakeError, SettingsError},
    setting::Setting,
};
use lapidary_core::dataset::{BakePart, BakeParts, BakeSettings, Dataset};

/// Puts the result of a part into the dataset.
pub type Put = Box<dyn FnOnce(&mut Dataset)>;

/// A part of a bake.
pub trait PartBake {
    /// Sets its draft settings.
    fn draft(&self, settings: &mut BakeSettings);

    /// Checks its settings.
    ///
    /// # Errors
    /// The first setting out of range.
    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError>;

    /// Checks its settings against a scene whose bounds have this `diagonal` in meters.
    ///
    /// # Errors
    /// A setting that does not fit the scene.
    fn check_scene(&self, _settings: &BakeSettings, _diagonal: f32) -> Result<(), BakeError> {
        Ok(())
    }

    /// Estimated bytes for this many vertices, beside the scene and its hierarchy.
    fn memory(&self, vertices: u64, settings: &BakeSettings, threads: usize) -> u64;

    /// The setting that reduces its size, besides the number of vertices and the bounds of cuts.
    fn size(&self) -> Option<Setting> {
        None
    }

    /// Bakes the part. Distant light precedes all parts, because every dataset has its cuts and tree.
    ///
    /// # Errors
    /// See [`BakeError`].
    fn bake(&self, _bouncing: &Bouncing, _clock: &mut Clock) -> Result<Put, BakeError> {
        Ok(Box::new(|_| {}))
    }
}

/// The table of all parts.
pub fn part(part: BakePart) -> &'static dyn PartBake {
    match part {
        BakePart::Environment => &environment::EnvironmentBake,
        BakePart::Sources => &sources::SourcesBake,
        BakePart::Meshless => &meshless::BasisBake,
        BakePart::ObjectBases => &object_bases::ObjectBasesBake,
        BakePart::Wavelet => &wavelet::WaveletBake,
    }
}

/// All parts, baked or not.
pub fn all() -> impl Iterator<Item = &'static dyn PartBake> {
    BakePart::ALL.iter().map(|&kind| part(kind))
}

/// The parts to bake.
pub fn of(parts: BakeParts) -> impl Iterator<Item = &'static dyn PartBake> {
    parts.parts().map(part)
}

/// A numeric setting with its value and limits.
pub type Range = (Setting, f64, f64, f64);

/// Checks numbers.
///
/// # Errors
/// The first one out of range.
pub fn within(ranges: &[Range]) -> Result<(), SettingsError> {
    match ranges.iter().find(|(_, value, low, high)| !(value >= low && value <= high)) {
        Some(&(setting, value, low, high)) => Err(SettingsError::Range { setting, value, low, high }),
        None => Ok(()),
    }
}

/// Bytes of packed cuts.
fn cuts(points: u64, nodes: u64) -> u64 {
    points * nodes * 2
}

/// Bytes of pilot visibility, and of a thread's visibility, sums and cut over lights or sources.
fn buffers(leaves: u64, settings: &BakeSettings, threads: usize) -> u64 {
    leaves * settings.pilot_clusters as u64 + threads as u64 * leaves * 20
}
