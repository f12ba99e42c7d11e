//! Why a checkpoint is of no use.

use std::{io, path::PathBuf};
use thiserror::Error;

/// Why a checkpoint cannot be used or written.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The file system refused.
    #[error("cannot {action} the checkpoint: {source}; check permissions and free space, finished chunks are kept ({})", path.display())]
    Io {
        /// `read`, `write` or `remove`.
        action: &'static str,
        /// Which file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The checkpoint belongs to another bake.
    #[error("the checkpoint was made with another scene or other settings; use the same options, or leave out --resume to start over ({})", path.display())]
    Mismatch {
        /// Which folder.
        path: PathBuf,
    },
}
