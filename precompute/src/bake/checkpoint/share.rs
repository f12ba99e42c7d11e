//! Additional files in the folder of a share: `shard.json` names its shard, and `scene.cuts` in the first one's folder holds the
//! tessellated scene with fully occluded cuts, once that share is complete.

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

/// Name of the file that names a share's shard.
pub const SHARD: &str = "shard.json";
/// Name of the file of the tessellated scene.
pub const SCENE: &str = "scene.cuts";

/// Checks that a folder holds the share of a shard: `None` if it does not say.
///
/// # Errors
/// The share of another shard.
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

/// The error of a share with an unusable checkpoint.
pub fn of_no_use(shard: Shard, folder: &Path, reason: CheckpointError) -> BakeError {
    let reason = match reason {
        CheckpointError::Mismatch { .. } => "it was made with another scene or other settings".into(),
        CheckpointError::Damaged { reason, .. } => format!("it is damaged, or of another version: {reason}"),
        other => return other.into(),
    };
    ShardError::OfNoUse { shard, path: folder.into(), reason }.into()
}

impl Checkpoint {
    /// Writes the name of this share's shard, if it is a share.
    pub(super) fn sign(&self) -> Result<(), CheckpointError> {
        let Work::Share(shard) = self.work else { return Ok(()) };
        let text = serde_json::json!([shard.index(), shard.count()]).to_string();
        self.write(SHARD, text.as_bytes())
    }

    /// Opens the share that a shard has started, if any.
    ///
    /// # Errors
    /// An unusable share, or another shard's share.
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

    /// Locks the shares to be merged for reading and removal.
    ///
    /// # Errors
    /// A shard is still being baked.
    pub fn lock_shares(&self) -> Result<Vec<OutputLock>, LockError> {
        self.known.iter().map(|(folder, _)| OutputLock::acquire(folder)).collect()
    }

    /// Stores the scene of a complete share. Any shard could do it; the first one does.
    ///
    /// # Errors
    /// An unwritable file.
    pub fn keep_scene(&self, scene: &Dataset) -> Result<(), BakeError> {
        match self.work {
            Work::Share(shard) if shard.index() == 1 => Ok(scene.write(&self.folder.join(SCENE))?),
            _ => Ok(()),
        }
    }

    /// The error of shares with the scene of another bake.
    pub fn foreign_scene(&self) -> BakeError {
        let (path, first) = (self.folder.join(SCENE), self.folder.join(manifest::FILE));
        ShardError::OfAnother { shard: Shard::first(self.known.len()), path, first }.into()
    }

    /// The scene of the shares. `decode` decodes its pictures.
    ///
    /// # Errors
    /// The first share is incomplete, or its scene cannot be read.
    pub fn scene(&self, decode: DecodePicture) -> Result<Dataset, BakeError> {
        let path = self.folder.join(SCENE);
        match path.try_exists() {
            Ok(true) => Ok(Dataset::read(&path, decode)?),
            Ok(false) => Err(ShardError::Incomplete { shard: Shard::first(self.known.len()), path }.into()),
            Err(e) => Err(io_error("read", &path, e).into()),
        }
    }
}
