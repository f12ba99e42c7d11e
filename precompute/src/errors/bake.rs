//! Why a bake did not finish.

use super::{checkpoint::CheckpointError, points::PointsError, settings::SettingsError};
use crate::observer::Observer;
use lapidary_core::{dataset::DatasetError, meshless::BasisError};
use thiserror::Error;

/// Why a bake did not finish.
#[derive(Debug, Error)]
pub enum BakeError {
    /// The observer asked for it.
    #[error("the bake was cancelled; run the same command with --resume to go on from the last finished chunk")]
    Cancelled,
    /// No surface for sources, or no viewpoint to find it from.
    #[error(transparent)]
    Points(PointsError),
    /// The points that were placed make no meshless basis.
    #[error("the points on the surfaces make no meshless basis: {0}")]
    Basis(#[from] BasisError),
    /// Settings out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The checkpoint cannot be used or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The dataset cannot be written.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// More memory than there is.
    #[error("the bake needs about {needed} MB of memory, {available} MB are free; {remedy}, or close other programs")]
    Memory {
        /// What to do.
        remedy: &'static str,
        /// Estimated need.
        needed: u64,
        /// Free now.
        available: u64,
    },
    /// More texels than a texture holds.
    #[error("{cuts} take {texels} texels, a texture holds {limit}; {remedy}")]
    TooManyTexels {
        /// Which cuts.
        cuts: &'static str,
        /// What to do.
        remedy: &'static str,
        /// Texels needed.
        texels: usize,
        /// Texels of an 8192 x 8192 texture.
        limit: usize,
    },
}

impl From<PointsError> for BakeError {
    fn from(error: PointsError) -> Self {
        match error {
            PointsError::Cancelled => Self::Cancelled,
            error => Self::Points(error),
        }
    }
}

/// An error if the job should stop.
pub fn cancelled(observer: &dyn Observer) -> Result<(), BakeError> {
    if observer.cancelled() { Err(BakeError::Cancelled) } else { Ok(()) }
}
