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
        }
    }
}

impl fmt::Display for CheckpointError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Setting::name))
    }
}
