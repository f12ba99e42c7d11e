//! Errors of a bake or its parts. This file does not depend on the bake.

mod bake;
mod checkpoint;
mod points;
mod settings;

pub use crate::shard::ShardError;
pub use bake::{BakeError, CutsOf, cancelled};
pub use checkpoint::{CheckpointError, ManifestError};
pub use points::{LEAST_COARSE_RADIUS, PointsError};
pub use settings::SettingsError;
