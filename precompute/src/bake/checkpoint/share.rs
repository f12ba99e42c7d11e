//! What the folder of a share has beside its chunks: `shard.json` says which shard it is, and `scene.cuts` of the first holds
//! the tessellated scene, with cuts that see nothing, once its share is complete.

use super::{Checkpoint, Content, Work, io_error, manifest};
use crate::{
    errors::{BakeError, CheckpointError, ShardError},
    shard::Shard,
};
use lapidary_core::{
    dataset::{BakeSettings, Dataset, DecodePicture},
    input,
    lock::{LockError, OutputLock},
};
use std::path::Path;

/// Name of the file that says which shard a share is of.
pub const SHARD: &str = "shard.json";
/// Name of the file of the tessellated scene.
pub const SCENE: &str = "scene.cuts";

/// Whether a folder holds the share of a shard: `None` if it does not say.
///
/// # Errors
/// It holds that of another.
pub fn check_signature(shard: Shard, folder: &Path) -> Result<Option<()>, ShardError> {
    match shard_in(folder) {
        Some(found) if found != shard => Err(ShardError::Renamed { shard, found, path: folder.into() }),
        found => Ok(found.map(|_| ())),
    }
}

fn shard_in(folder: &Path) -> Option<Shard> {
    let [index, of]: [usize; 2] = serde_json::from_slice(&input::read(&folder.join(SHARD)).ok()?).ok()?;
    Shard::new(index, of).ok()
}

/// What is wrong with a share whose checkpoint is.
pub fn of_no_use(shard: Shard, folder: &Path, reason: CheckpointError) -> BakeError {
    let reason = match reason {
        CheckpointError::Mismatch { .. } => "it was made with another scene or other settings".into(),
        CheckpointError::Damaged { reason, .. } => format!("it is damaged, or of another version: {reason}"),
        other => return other.into(),
    };
    ShardError::OfNoUse { shard, path: folder.into(), reason }.into()
}

impl Checkpoint {
    /// Writes which shard's share this is, if it is one.
    pub(super) fn sign(&self) -> Result<(), CheckpointError> {
        let Work::Share(shard) = self.work else { return Ok(()) };
        let text = serde_json::json!([shard.index(), shard.count()]).to_string();
        self.write(SHARD, text.as_bytes())
    }

    /// Opens the share that a shard has begun, if any.
    ///
    /// # Errors
    /// A share that is of no use, or that of another shard.
    pub fn open_share(
        output: &Path,
        shard: Shard,
        content: &Content,
        settings: &BakeSettings,
    ) -> Result<Option<Self>, BakeError> {
        let folder = shard.folder_of(output);
        let opened = Self::open(output, &Work::Share(shard), content, settings);
        let Some(share) = opened.map_err(|reason| of_no_use(shard, &folder, reason))? else { return Ok(None) };
        if check_signature(shard, &folder)?.is_none() {
            share.sign()?;
        }
        Ok(Some(share))
    }

    /// The right to read and remove the shares that are merged, which no shard writes meanwhile.
    ///
    /// # Errors
    /// A shard is at work.
    pub fn lock_shares(&self) -> Result<Vec<OutputLock>, LockError> {
        self.known.iter().map(|(folder, _)| OutputLock::acquire(folder)).collect()
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

    /// The scene of the shares. `decode` decodes its pictures.
    ///
    /// # Errors
    /// The first share is not complete, or its scene cannot be read.
    pub fn scene(&self, decode: DecodePicture) -> Result<Dataset, BakeError> {
        let path = self.folder.join(SCENE);
        match path.try_exists() {
            Ok(true) => Ok(Dataset::read(&path, decode)?),
            Ok(false) => Err(ShardError::Incomplete { shard: Shard::first(self.known.len()), path }.into()),
            Err(e) => Err(io_error("read", &path, e).into()),
        }
    }
}
