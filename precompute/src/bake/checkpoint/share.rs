//! What the folder of a share has beside its chunks: `shard.json` says which shard it is, and `scene.cuts` of the first holds
//! the tessellated scene, with cuts that see nothing, once its share is complete.

use super::{Checkpoint, Work, io_error, manifest};
use crate::{
    errors::{BakeError, CheckpointError, ShardError},
    shard::Shard,
};
use lapidary_core::{dataset::Dataset, input};
use std::path::Path;

/// Name of the file that says which shard a share is of.
pub const SHARD: &str = "shard.json";
/// Name of the file of the tessellated scene.
pub const SCENE: &str = "scene.cuts";

/// The shard whose share a folder holds, if it says so.
pub fn shard_in(folder: &Path) -> Option<Shard> {
    let [index, of]: [usize; 2] = serde_json::from_slice(&input::read(&folder.join(SHARD)).ok()?).ok()?;
    Shard::new(index, of).ok()
}

impl Checkpoint {
    /// Writes which shard's share this is, if it is one.
    pub(super) fn sign(&self) -> Result<(), CheckpointError> {
        let Work::Share(shard) = self.work else { return Ok(()) };
        let text = serde_json::json!([shard.index(), shard.count()]).to_string();
        self.write(SHARD, text.as_bytes())
    }

    /// Keeps the scene of a complete share, which any of the shards could; the first does.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep_scene(&self, scene: &Dataset) -> Result<(), BakeError> {
        match self.work {
            Work::Share(shard) if shard.index() == 1 => Ok(scene.write(&self.folder.join(SCENE))?),
            _ => Ok(()),
        }
    }

    /// What is wrong with shares whose scene is that of another bake.
    pub fn foreign_scene(&self) -> BakeError {
        let (path, first) = (self.folder.join(SCENE), self.folder.join(manifest::FILE));
        ShardError::OfAnother { shard: Shard::first(self.known.len()), path, first }.into()
    }

    /// The scene of the shares.
    ///
    /// # Errors
    /// The first share is not complete, or its scene cannot be read.
    pub fn scene(&self) -> Result<Dataset, BakeError> {
        let path = self.folder.join(SCENE);
        match path.try_exists() {
            Ok(true) => Ok(Dataset::read(&path)?),
            Ok(false) => Err(ShardError::Incomplete { shard: Shard::first(self.known.len()), path }.into()),
            Err(e) => Err(io_error("read", &path, e).into()),
        }
    }
}
