//! Checkpoints: finished chunks of a bake beside its output, so that an interrupted bake can resume.
//!
//! `FILE.cuts.partial/` holds `bake.json` (a fingerprint of scene and settings, the number of chunks, the order of the
//! light tree) and one file per finished chunk. A chunk's file is written under a temporary name, renamed, and carries
//! a checksum: a chunk is either complete or baked again. Some chunks also depend on points that cameras and lights
//! influence, as hints for the viewpoint. Such chunks are valid for those points only, see `checkpoint/places.rs`.

mod places;
mod rows;

pub use places::Part;

use super::settings::ResolvedBake;
use crate::errors::CheckpointError;
use lapidary_core::{dataset::BakeSettings, output::write_atomically};
use serde::{Deserialize, Serialize};
use std::{
    fs, io,
    ops::Range,
    path::{Path, PathBuf},
};

/// The cuts of a range of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chunk {
    /// Nodes of all cuts, one after the other.
    pub nodes: Vec<u16>,
    /// Number of nodes of each cut.
    pub lengths: Vec<u32>,
    /// Sum of squared errors of stored visibility.
    pub squared_error: f64,
    /// Rays traced.
    pub rays: u64,
}

impl Chunk {
    /// Adds the cut of one more point, its squared error, and the rays that were traced for it.
    pub fn push(&mut self, cut: &[u16], squared_error: f64, rays: u64) {
        self.lengths.push(cut.len() as u32);
        self.nodes.extend_from_slice(cut);
        self.squared_error += squared_error;
        self.rays += rays;
    }
}

/// Which cuts a chunk holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// Cuts of the bake points over the environment's lights.
    Environment,
    /// Cuts of the bake points over the surface sources.
    Sources,
    /// Cuts of the surface sources over the environment's lights.
    SourceEnvironment,
}

/// Identity of the bake that a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Manifest {
    version: u32,
    scene_hash: String,
    settings: BakeSettings,
    points: usize,
    chunks: usize,
    tree_order: Vec<u32>,
}

/// What an interrupted bake left beside its output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leftover {
    /// Nothing.
    #[default]
    Nothing,
    /// Chunks of another scene or of other settings, which cannot be resumed.
    OfAnother,
    /// Chunks to resume from.
    Fitting,
}

/// What an interrupted bake left beside `output`, judged for a bake of this scene with these settings.
pub fn leftover(output: &Path, scene_hash: &str, settings: &ResolvedBake) -> Leftover {
    match Checkpoint::open(output, scene_hash, settings) {
        Ok(Some(_)) => Leftover::Fitting,
        Ok(None) => Leftover::Nothing,
        Err(_) => Leftover::OfAnother,
    }
}

/// The folder of a bake in progress.
pub struct Checkpoint {
    folder: PathBuf,
    manifest: Manifest,
}

/// Changes whenever the same settings would give different chunks.
const VERSION: u32 = 12;

impl Checkpoint {
    /// The folder beside an output file.
    pub fn folder_of(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".partial");
        name.into()
    }

    /// Starts anew and discards the contents of the folder.
    pub fn create(
        output: &Path,
        scene_hash: &str,
        settings: &BakeSettings,
        points: usize,
        chunks: usize,
        tree_order: &[u32],
    ) -> Result<Self, CheckpointError> {
        let folder = Self::folder_of(output);
        let manifest = Manifest {
            version: VERSION,
            scene_hash: scene_hash.into(),
            settings: settings.clone(),
            points,
            chunks: chunks.clamp(1, points.max(1)),
            tree_order: tree_order.to_vec(),
        };
        if folder.exists() {
            fs::remove_dir_all(&folder).map_err(|e| io_error("remove", &folder, e))?;
        }
        fs::create_dir(&folder).map_err(|e| io_error("write", &folder, e))?;
        let checkpoint = Self { folder, manifest };
        let json = serde_json::to_vec(&checkpoint.manifest).unwrap_or_default();
        checkpoint.write("bake.json", &json)?;
        Ok(checkpoint)
    }

    /// Opens what an interrupted bake left, if anything.
    ///
    /// # Errors
    /// A checkpoint of another scene or other settings.
    pub fn open(output: &Path, scene_hash: &str, settings: &BakeSettings) -> Result<Option<Self>, CheckpointError> {
        let folder = Self::folder_of(output);
        let file = folder.join("bake.json");
        let bytes = match fs::read(&file) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(io_error("read", &file, e)),
        };
        match serde_json::from_slice::<Manifest>(&bytes) {
            Ok(m) if m.version == VERSION && m.scene_hash == scene_hash && m.settings == *settings => {
                Ok(Some(Self { folder, manifest: m }))
            }
            _ => Err(CheckpointError::Mismatch { path: folder }),
        }
    }

    /// Number of chunks.
    pub fn chunks(&self) -> usize {
        self.manifest.chunks
    }

    /// Number of bake points in all chunks.
    pub fn points(&self) -> usize {
        self.manifest.points
    }

    /// Order of the light tree that the chunks were baked with.
    pub fn tree_order(&self) -> &[u32] {
        &self.manifest.tree_order
    }

    /// Which of `count` points a chunk holds.
    pub fn range(&self, count: usize, chunk: usize) -> Range<usize> {
        let chunks = self.manifest.chunks;
        chunk * count / chunks..(chunk + 1) * count / chunks
    }

    /// A finished chunk of `count` cuts, or `None` if it is missing or damaged.
    pub fn load(&self, series: Series, chunk: usize, count: usize) -> Option<Chunk> {
        let bytes = fs::read(self.folder.join(chunk_name(series, chunk))).ok()?;
        decode(&bytes).filter(|c| c.lengths.len() == count)
    }

    /// Keeps a finished chunk.
    pub fn store(&self, series: Series, index: usize, chunk: &Chunk) -> Result<(), CheckpointError> {
        self.write(&chunk_name(series, index), &encode(chunk))
    }

    /// Removes the checkpoint when its bake is complete.
    pub fn remove(self) -> Result<(), CheckpointError> {
        fs::remove_dir_all(&self.folder).map_err(|e| io_error("remove", &self.folder, e))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), CheckpointError> {
        let path = self.folder.join(name);
        write_atomically(&path, bytes).map_err(|e| io_error("write", &path, e))
    }
}

fn io_error(action: &'static str, path: &Path, source: io::Error) -> CheckpointError {
    CheckpointError::Io { action, path: path.into(), source }
}

fn chunk_name(series: Series, chunk: usize) -> String {
    let prefix = match series {
        Series::Environment => "",
        Series::Sources => "source-",
        Series::SourceEnvironment => "source-environment-",
    };
    format!("{prefix}chunk-{chunk:05}.bin")
}

/// BLAKE3 of the rest (32 bytes), squared error (f64), rays (u64), number of cuts (u64), lengths (u32), nodes (u16).
fn encode(chunk: &Chunk) -> Vec<u8> {
    let mut body = Vec::with_capacity(24 + 4 * chunk.lengths.len() + 2 * chunk.nodes.len());
    body.extend(chunk.squared_error.to_le_bytes());
    body.extend(chunk.rays.to_le_bytes());
    body.extend((chunk.lengths.len() as u64).to_le_bytes());
    body.extend_from_slice(bytemuck::cast_slice(&chunk.lengths));
    body.extend_from_slice(bytemuck::cast_slice(&chunk.nodes));
    sealed(&body)
}

/// A body after its checksum.
fn sealed(body: &[u8]) -> Vec<u8> {
    [blake3::hash(body).as_bytes().as_slice(), body].concat()
}

/// The body if it fits its checksum.
fn unsealed(bytes: &[u8]) -> Option<&[u8]> {
    let (hash, body) = bytes.split_at_checked(32)?;
    (blake3::hash(body).as_bytes() == hash).then_some(body)
}

fn decode(bytes: &[u8]) -> Option<Chunk> {
    let body = unsealed(bytes)?;
    let (head, rest) = body.split_at_checked(24)?;
    let word = |i: usize| head[8 * i..8 * i + 8].try_into().map(u64::from_le_bytes).ok();
    let (lengths, nodes) = rest.split_at_checked(4 * usize::try_from(word(2)?).ok()?)?;
    Some(Chunk {
        squared_error: f64::from_bits(word(0)?),
        rays: word(1)?,
        lengths: lengths.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect(),
        nodes: nodes.chunks_exact(2).map(bytemuck::pod_read_unaligned).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::settings::resolve;

    #[test]
    fn chunks_survive_and_damaged_ones_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let settings = BakeSettings::default();
        let checkpoint = Checkpoint::create(&output, "hash", &settings, 10, 3, &[0, 1]).unwrap();
        let chunk = Chunk { nodes: vec![7, 8, 9], lengths: vec![1, 1, 1], squared_error: 0.25, rays: 99 };
        checkpoint.store(Series::Environment, 0, &chunk).unwrap();
        let reopened = Checkpoint::open(&output, "hash", &settings).unwrap().unwrap();
        let load = |index, count| reopened.load(Series::Environment, index, count);
        assert_eq!(load(0, 3), Some(chunk));
        assert_eq!((load(0, 4), load(1, 3), reopened.load(Series::Sources, 0, 3)), (None, None, None));
        assert_eq!((0..3).map(|c| reopened.range(10, c).len()).sum::<usize>(), 10);
        let file = Checkpoint::folder_of(&output).join(chunk_name(Series::Environment, 0));
        let mut bytes = fs::read(&file).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&file, &bytes).unwrap();
        assert_eq!(load(0, 3), None);
        fs::write(&file, &bytes[..20]).unwrap();
        assert_eq!(load(0, 3), None);
    }

    #[test]
    fn a_checkpoint_of_another_bake_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let settings = resolve(BakeSettings::default()).unwrap();
        assert!(Checkpoint::open(&output, "hash", &settings).unwrap().is_none());
        assert_eq!(leftover(&output, "hash", &settings), Leftover::Nothing);
        Checkpoint::create(&output, "hash", &settings, 10, 3, &[]).unwrap();
        assert!(matches!(Checkpoint::open(&output, "other", &settings), Err(CheckpointError::Mismatch { .. })));
        let other = resolve(BakeSettings { beta: 0.4, ..Default::default() }).unwrap();
        assert!(matches!(Checkpoint::open(&output, "hash", &other), Err(CheckpointError::Mismatch { .. })));
        assert_eq!(leftover(&output, "hash", &other), Leftover::OfAnother);
        assert_eq!(leftover(&output, "hash", &settings), Leftover::Fitting);
    }
}
