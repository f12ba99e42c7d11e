//! Data of each bake part in a dataset: its settings, its tensors, and their checks.

use super::{
    Dataset, error::Damage, meshless::StoredBasis, object_bases::StoredObjectBases, parts::BakePart, reader::Reader,
    sources::StoredSources, tensors::Tensor, wavelet::StoredWavelet,
};
use crate::{ray::is_number_per_probe, shot::Shot};

/// A bake part in a dataset. A part without tensors has only settings.
pub(super) trait StoredPart {
    /// Whether a dataset has it.
    fn is_in(&self, dataset: &Dataset) -> bool;

    /// Its tensors; none if it was not baked.
    fn tensors<'a>(&self, _dataset: &'a Dataset) -> Vec<Tensor<'a>> {
        Vec::new()
    }

    /// Reads it into a dataset that already has scene, light tree, settings and report.
    fn read(&self, _reader: &Reader, _dataset: &mut Dataset) -> Result<(), Damage> {
        Ok(())
    }

    /// Settings for a verification and results of the bake: each by name, and whether it is in its range. The bake
    /// itself has narrower ranges.
    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)>;

    /// Checks the stored data.
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
        BakePart::ObjectBases => &StoredObjectBases,
        BakePart::Wavelet => &StoredWavelet,
    }
}

/// All parts, baked or not.
pub(super) fn all_stored() -> impl Iterator<Item = &'static dyn StoredPart> {
    BakePart::ALL.iter().map(|part| stored(*part))
}

/// Visibility of distant light. Every dataset has its cuts; they are dark if it was not baked.
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

/// Whether a number is valid as a length, an area or a bound.
pub(super) fn is_size(number: f32) -> bool {
    number.is_finite() && number >= 0.0
}
