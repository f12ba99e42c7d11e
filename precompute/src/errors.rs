//! Why a bake, or a part of it, did not finish. This file depends on nothing that bakes.

mod bake;
mod checkpoint;
mod points;
mod settings;

pub use crate::shard::ShardError;
pub use bake::{BakeError, CutsOf, cancelled};
pub use checkpoint::{CheckpointError, ManifestError};
pub use points::{LEAST_COARSE_RADIUS, PointsError};
pub use settings::SettingsError;
