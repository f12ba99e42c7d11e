//! Why a checkpoint is of no use.

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
        /// Which file or folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The checkpoint belongs to another bake.
    Mismatch {
        /// Which folder.
        path: PathBuf,
    },
    /// The checkpoint is not what was written.
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        reason: ManifestError,
    },
    /// A finished chunk was taken away or changed while its bake went on.
    Lost {
        /// Its file.
        path: PathBuf,
    },
    /// Something lies where the checkpoint would be that no bake has put there.
    Foreign {
        /// Which file or folder.
        path: PathBuf,
    },
}

/// Why a manifest is of no use.
#[derive(Debug, Error)]
pub enum ManifestError {
    /// No JSON, or that of another version.
    #[error("bake.json cannot be read ({0})")]
    Json(#[from] serde_json::Error),
    /// It is not what was written.
    #[error("bake.json does not match its checksum")]
    Checksum,
    /// The number of chunks.
    #[error("bake.json has {chunks} chunks for {points} points")]
    Chunks {
        /// Number of chunks.
        chunks: usize,
        /// Number of bake points.
        points: usize,
    },
    /// The order of the light tree.
    #[error("bake.json has an order of the light tree that is no permutation of {lights} lights")]
    TreeOrder {
        /// Number of lights.
        lights: usize,
    },
}

impl CheckpointError {
    /// In words, with settings called by `name`.
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
                "a finished part of the bake was removed or changed meanwhile; bake again with {}, which makes it anew ({})",
                name(Setting::Resume),
                path.display()
            ),
            Self::Foreign { path } => format!(
                "this is no part of a checkpoint, but lies where the checkpoint of the bake would be; move it elsewhere, \
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
