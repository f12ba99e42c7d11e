//! Checkpoints: finished chunks of a bake beside its output, so that an interrupted bake can resume.
//!
//! `FILE.cuts.partial/` holds `bake.json` (scene, settings, number of chunks, order of the light tree) and one file per finished
//! chunk. Each has a checksum and is written under a temporary name and renamed, so it is either complete or recomputed. A chunk's
//! file also identifies its bake, series, number and points, and is never read as anything else. Foreign files are never removed.

mod chunk;
mod folder;
mod identity;
mod manifest;
mod rows;
mod share;
mod work;

pub use chunk::Chunk;
pub use identity::Places;
pub use manifest::Content;
pub use work::{Work, shards_beside};

use super::settings::ResolvedBake;
use crate::errors::{BakeError, CheckpointError, ShardError};
use crate::shard::Shard;
use folder::{Contents, is_there, remove};
use identity::{Identity, Seal};
use lapidary_core::{dataset::BakeSettings, input, output::write_atomically};
use manifest::Manifest;
use std::{
    cell::Cell,
    fs, io, iter,
    ops::Range,
    path::{Path, PathBuf},
};

/// Contents of a series of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// Cuts of the bake points over the environment's lights.
    Environment,
    /// Cuts of the bake points over the surface sources.
    Sources,
    /// Cuts of the surface sources over the environment's lights.
    SourceEnvironment,
    /// Rows of the meshless operator.
    Transport,
}

impl Series {
    /// All series.
    const ALL: [Self; 4] = [Self::Environment, Self::Sources, Self::SourceEnvironment, Self::Transport];

    /// Prefix of its file names.
    fn prefix(self) -> &'static str {
        match self {
            Self::Environment => "chunk-",
            Self::Sources => "source-chunk-",
            Self::SourceEnvironment => "source-environment-chunk-",
            Self::Transport => "transport-",
        }
    }

    fn file_name(self, index: usize) -> String {
        format!("{}{index:05}.bin", self.prefix())
    }
}

/// Remains of an interrupted bake beside its output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leftover {
    /// Nothing.
    #[default]
    Nothing,
    /// Damaged chunks, or chunks of another scene or other settings, which cannot be resumed.
    OfAnother,
    /// Chunks to resume from.
    Fitting,
}

/// Finds the remains of an interrupted bake beside `output` and compares them with a bake of this scene with these settings. It
/// does not compare animation deformations: only the bake knows them and rejects chunks of other keyframes.
pub fn leftover(output: &Path, scene_hash: &str, settings: &ResolvedBake) -> Leftover {
    match manifest_in(&Checkpoint::folder_of(output)) {
        Ok(Some(manifest)) if manifest.is_of_scene(scene_hash, settings) => Leftover::Fitting,
        Ok(None) => Leftover::Nothing,
        Ok(Some(_)) | Err(_) => Leftover::OfAnother,
    }
}

/// The folder of a bake in progress. The bake holds the lock of the output.
#[derive(Debug)]
pub struct Checkpoint {
    folder: PathBuf,
    manifest: Manifest,
    /// Folders with usable files, and their shards.
    known: Vec<(PathBuf, Option<Shard>)>,
    work: Work,
}

impl Checkpoint {
    /// The folder beside an output file.
    pub fn folder_of(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".partial");
        name.into()
    }

    /// Whether an interrupted bake left files in a folder.
    ///
    /// # Errors
    /// Another file or link has the checkpoint's name.
    pub fn is_left(folder: &Path) -> Result<bool, CheckpointError> {
        Ok(is_there(folder)? && !Contents::of(folder)?.all_ours()?.is_empty())
    }

    /// Starts work afresh and discards an earlier checkpoint.
    ///
    /// # Errors
    /// A folder that is not a checkpoint, or an unwritable one.
    pub fn create(
        output: &Path,
        work: &Work,
        content: Content,
        settings: &BakeSettings,
        points: usize,
        chunks: usize,
        tree_order: &[u32],
    ) -> Result<Self, CheckpointError> {
        let folder = work.folder_of(output);
        if is_there(&folder)? {
            remove(&Contents::of(&folder)?.all_ours()?)?;
        } else {
            fs::create_dir(&folder).map_err(|e| io_error("write", &folder, e))?;
        }
        let manifest = Manifest::new(content, settings, points, chunks, tree_order);
        let checkpoint = Self { folder, manifest, known: Vec::new(), work: work.clone() };
        // Sign first: a folder with a manifest will be resumed.
        checkpoint.sign()?;
        checkpoint.write(manifest::FILE, &checkpoint.manifest.sealed())?;
        Ok(checkpoint)
    }

    /// Opens the checkpoint of interrupted work, if any.
    ///
    /// # Errors
    /// A checkpoint of another scene or other settings, or a damaged one.
    pub fn open(
        output: &Path,
        work: &Work,
        content: &Content,
        settings: &BakeSettings,
    ) -> Result<Option<Self>, CheckpointError> {
        let folder = work.folder_of(output);
        let Some(manifest) = manifest_in(&folder)? else { return Ok(None) };
        if !manifest.is_of(content, settings) {
            return Err(CheckpointError::Mismatch { path: folder });
        }
        let known = vec![(folder.clone(), None)];
        Ok(Some(Self { folder, manifest, known, work: work.clone() }))
    }

    /// The shares of all shards beside `output`, for a bake that computes no chunk.
    ///
    /// # Errors
    /// Missing shares, or shares of different bakes.
    pub fn of_shares(output: &Path) -> Result<Self, BakeError> {
        let shards = shards_beside(output)?;
        let folder_of = |shard: &Shard| shard.folder_of(output);
        let known: Vec<(PathBuf, Option<Shard>)> = shards.iter().map(|s| (folder_of(s), Some(*s))).collect();
        let mut first: Option<Manifest> = None;
        for (folder, shard) in shards.iter().map(|shard| (folder_of(shard), *shard)) {
            let incomplete = || ShardError::Incomplete { shard, path: folder.clone() };
            // A link may lead anywhere, and its target would be removed.
            if !is_there(&folder)? {
                return Err(incomplete().into());
            }
            let found = manifest_in(&folder).map_err(|reason| share::of_no_use(shard, &folder, reason))?;
            let manifest = found.ok_or_else(incomplete)?;
            share::check_signature(shard, &folder)?.ok_or_else(incomplete)?;
            match &first {
                Some(first) if *first != manifest => {
                    let first = folder_of(&shards[0]);
                    return Err(ShardError::OfAnother { shard, path: folder, first }.into());
                }
                _ => first = Some(manifest),
            }
        }
        let manifest = first.ok_or_else(|| ShardError::NoShares { path: output.into() })?;
        Ok(Self { folder: known[0].0.clone(), manifest, known, work: Work::Merge(shards) })
    }

    /// Whether it belongs to a bake of this scene with these settings and number of bake points, regardless of animation.
    pub fn is_of_scene(&self, scene_hash: &str, settings: &BakeSettings, points: usize) -> bool {
        self.manifest.is_of_scene(scene_hash, settings) && self.points() == points
    }

    /// Number of bake points in all chunks.
    pub fn points(&self) -> usize {
        self.manifest.points
    }

    /// Order of the light tree that the chunks were baked with.
    pub fn tree_order(&self) -> &[u32] {
        &self.manifest.tree_order
    }

    /// The files of a series for these points.
    pub fn series(&self, series: Series, places: Places) -> Kept<'_> {
        let identity = Identity { bake: self.manifest.fingerprint(), series: series.prefix() };
        Kept { checkpoint: self, series, identity, places, others: Cell::new(false) }
    }

    /// Removes the checkpoint, or all shares, after the bake is complete. Returns a foreign file, if any, because of which the
    /// folder stays.
    ///
    /// # Errors
    /// Files that cannot be removed.
    pub fn remove(self) -> Result<Option<PathBuf>, CheckpointError> {
        let folders = match self.work {
            Work::Merge(_) => self.known.into_iter().map(|(folder, _)| folder).collect(),
            Work::All | Work::Share(_) => vec![self.folder],
        };
        let mut kept = None;
        for folder in folders {
            let Contents { ours, foreign } = Contents::of(&folder)?;
            remove(&ours)?;
            if foreign.is_none() {
                fs::remove_dir(&folder).map_err(|e| io_error("remove", &folder, e))?;
            }
            kept = kept.or(foreign);
        }
        Ok(kept)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), CheckpointError> {
        let path = self.folder.join(name);
        write_atomically(&path, bytes).map_err(|e| io_error("write", &path, e))
    }
}

/// The files of one series of a checkpoint.
pub struct Kept<'a> {
    checkpoint: &'a Checkpoint,
    series: Series,
    identity: Identity,
    places: Places,
    others: Cell<bool>,
}

impl Kept<'_> {
    /// Number of chunks.
    pub fn chunks(&self) -> usize {
        self.checkpoint.manifest.chunks
    }

    /// Whether this bake computes or reads the chunk of an index; otherwise another shard computes it.
    pub fn has(&self, index: usize) -> bool {
        self.checkpoint.work.has(index)
    }

    /// Checks that a missing chunk may be computed.
    ///
    /// # Errors
    /// In a merge: the share that lacks the chunk, or has it for other points.
    pub fn may_make(&self, index: usize) -> Result<(), ShardError> {
        let Work::Merge(_) = self.checkpoint.work else { return Ok(()) };
        let shares = self.checkpoint.known.iter().filter_map(|(folder, shard)| Some((folder, (*shard)?)));
        let Some((folder, shard)) = shares.into_iter().find(|(_, shard)| shard.makes(index)) else { return Ok(()) };
        let path = folder.join(self.series.file_name(index));
        let first = self.checkpoint.folder.clone();
        Err(match self.has_met_others() {
            true => ShardError::OfAnother { shard, path, first },
            false => ShardError::Incomplete { shard, path },
        })
    }

    /// The points of a chunk among `count` points.
    pub fn range(&self, count: usize, chunk: usize) -> Range<usize> {
        let part = |chunk: usize| (chunk as u128 * count as u128 / self.chunks() as u128) as usize;
        part(chunk)..part(chunk + 1)
    }

    /// A finished chunk of `count` cuts over a tree of `height`, or `None` if it is missing or damaged.
    pub fn load(&self, index: usize, count: usize, height: u32) -> Option<Chunk> {
        self.load_body(index).and_then(|body| Chunk::decoded(&body, count, height))
    }

    /// Reads a kept chunk again.
    ///
    /// # Errors
    /// A file that has become unreadable; in a merge, the share that lost it.
    pub fn again(&self, index: usize, count: usize, height: u32) -> Result<Chunk, BakeError> {
        let folder = &self.checkpoint.folder;
        let mut folders = iter::once(folder).chain(self.checkpoint.known.iter().map(|(folder, _)| folder));
        let body = folders.find_map(|folder| self.body_in(folder, index));
        let chunk = body.and_then(|body| Chunk::decoded(&body, count, height));
        if let Some(chunk) = chunk {
            return Ok(chunk);
        }
        self.may_make(index)?;
        let path = folder.join(self.series.file_name(index));
        Err(match input::read(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => io_error("read", &path, source),
            _ => CheckpointError::Lost { path },
        })?
    }

    /// Stores a finished chunk.
    pub fn store(&self, index: usize, chunk: &Chunk) -> Result<(), CheckpointError> {
        self.store_body(index, &chunk.encoded())
    }

    /// Whether files for other points were found. Such files are not used.
    pub fn has_met_others(&self) -> bool {
        self.others.get()
    }

    fn load_body(&self, index: usize) -> Option<Vec<u8>> {
        self.checkpoint.known.iter().find_map(|(folder, _)| self.body_in(folder, index))
    }

    fn body_in(&self, folder: &Path, index: usize) -> Option<Vec<u8>> {
        let bytes = input::read(&folder.join(self.series.file_name(index))).ok()?;
        match self.identity.unsealed(&bytes, self.places, index) {
            Seal::Fits(body) => Some(body.to_vec()),
            Seal::OtherPlaces => {
                self.others.set(true);
                None
            }
            Seal::Broken => None,
        }
    }

    fn store_body(&self, index: usize, body: &[u8]) -> Result<(), CheckpointError> {
        let sealed = self.identity.sealed(body, self.places, index);
        self.checkpoint.write(&self.series.file_name(index), &sealed)
    }
}

/// The manifest of a checkpoint's folder, if there is one.
fn manifest_in(folder: &Path) -> Result<Option<Manifest>, CheckpointError> {
    let file = folder.join(manifest::FILE);
    let bytes = match input::read(&file) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(io_error("read", &file, e)),
    };
    let manifest = Manifest::unsealed(&bytes).map_err(|reason| CheckpointError::Damaged { path: file, reason })?;
    Ok(Some(manifest))
}

fn io_error(action: &'static str, path: &Path, source: io::Error) -> CheckpointError {
    CheckpointError::Io { action, path: path.into(), source }
}

#[cfg(test)]
mod tests;
