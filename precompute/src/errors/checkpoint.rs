//! Errors of checkpoints.

use crate::setting::{Naming, Setting};
use std::{fmt, io, path::PathBuf};
use thiserror::Error;

/// Why a checkpoint cannot be used or written.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The file system refused.
    Io {
        /// `read`, `write` or `remove`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The checkpoint belongs to another bake.
    Mismatch {
        /// The folder.
        path: PathBuf,
    },
    /// The checkpoint is damaged.
    Damaged {
        /// The file.
        path: PathBuf,
        /// The damage.
        reason: ManifestError,
    },
    /// A finished chunk was removed or changed during the bake.
    Lost {
        /// Its file.
        path: PathBuf,
    },
    /// A foreign file has the checkpoint's place.
    Foreign {
        /// The file or folder.
        path: PathBuf,
    },
}

/// Why a manifest is unusable.
#[derive(Debug, Error)]
pub enum ManifestError {
    /// Invalid JSON, or another version's.
    #[error("bake.json cannot be read ({0})")]
    Json(#[from] serde_json::Error),
    /// The checksum does not match.
    #[error("bake.json does not match its checksum")]
    Checksum,
    /// The number of chunks is invalid.
    #[error("bake.json has {chunks} chunks for {points} points")]
    Chunks {
        /// Number of chunks.
        chunks: usize,
        /// Number of bake points.
        points: usize,
    },
    /// The order of the light tree is invalid.
    #[error("bake.json has an order of the light tree that is no permutation of {lights} lights")]
    TreeOrder {
        /// Number of lights.
        lights: usize,
    },
}

impl CheckpointError {
    /// The message, with settings named by `name`.
    pub fn text(&self, name: Naming) -> String {
        match self {
            Self::Io { action, path, source } => format!(
                "cannot {action} the checkpoint: {source}; check permissions and free space, finished chunks are kept ({})",
                path.display()
            ),
            Self::Mismatch { path } => format!(
                "the checkpoint was made with another scene or other settings; use the same ones, or leave out {} to start \
                 over ({})",
                name(Setting::Resume),
                path.display()
            ),
            Self::Damaged { path, reason } => format!(
                "the checkpoint is damaged, or of another version: {reason}; leave out {} to start over ({})",
                name(Setting::Resume),
                path.display()
            ),
            Self::Lost { path } => format!(
                "a finished part of the bake was removed or changed meanwhile; bake again with {} to recompute it ({})",
                name(Setting::Resume),
                path.display()
            ),
            Self::Foreign { path } => format!(
                "this is not part of a checkpoint, but has the place of the checkpoint; move it elsewhere, \
                 or choose another output ({})",
                path.display()
            ),
        }
    }
}

impl fmt::Display for CheckpointError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Setting::name))
    }
}
