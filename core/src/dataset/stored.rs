//! What each part of a bake has in a dataset: its settings, its tensors, and their checks.

use super::{
    Dataset, error::Damage, meshless::StoredBasis, parts::BakePart, reader::Reader, sources::StoredSources,
    tensors::Tensor,
};
use crate::{ray::is_number_per_probe, shot::Shot};

/// A part of a bake in a dataset. One without tensors of its own has only settings.
pub(super) trait StoredPart {
    /// Whether it is in a dataset.
    fn is_in(&self, dataset: &Dataset) -> bool;

    /// Its tensors; none if it was not baked.
    fn tensors<'a>(&self, _dataset: &'a Dataset) -> Vec<Tensor<'a>> {
        Vec::new()
    }

    /// Reads it into a dataset that has its scene, light tree, settings and report.
    fn read(&self, _reader: &Reader, _dataset: &mut Dataset) -> Result<(), Damage> {
        Ok(())
    }

    /// The settings that a verification uses, and what the bake made of them: each by name, and whether it is in its range. The bake
    /// itself has narrower ranges.
    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)>;

    /// Checks what is stored.
    fn check(&self, _dataset: &Dataset) -> Result<(), Damage> {
        Ok(())
    }
}

/// The table of all parts.
pub(super) fn stored(part: BakePart) -> &'static dyn StoredPart {
    match part {
        BakePart::Environment => &StoredEnvironment,
        BakePart::Sources => &StoredSources,
        BakePart::Meshless => &StoredBasis,
    }
}

/// All parts, baked or not.
pub(super) fn all_stored() -> impl Iterator<Item = &'static dyn StoredPart> {
    BakePart::ALL.iter().map(|part| stored(*part))
}

/// Visibility of distant light. Its cuts are in every dataset, and dark where it was not baked.
struct StoredEnvironment;

impl StoredPart for StoredEnvironment {
    fn is_in(&self, dataset: &Dataset) -> bool {
        dataset.settings.mode.environment()
    }

    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)> {
        let settings = &dataset.settings;
        vec![
            ("beta", settings.beta.is_finite()),
            ("sigma", is_size(settings.criterion.sigma)),
            ("total error", settings.criterion.total_error.is_none_or(is_size)),
            ("shots", settings.shots.iter().all(Shot::is_valid)),
            ("lights per probe", is_number_per_probe(dataset.report.lights_per_probe())),
        ]
    }
}

/// Whether a number may be a length, an area or a bound.
pub(super) fn is_size(number: f32) -> bool {
    number.is_finite() && number >= 0.0
}
