//! Result and errors of an export.

use crate::import::ImportError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Result of an export.
#[derive(Clone, Debug, Default)]
pub struct Exported {
    /// The written files, the requested one first.
    pub files: Vec<PathBuf>,
    /// Number of materials.
    pub materials: usize,
    /// Features that the format lacks, in sentences.
    pub remarks: Vec<String>,
}

/// Why materials cannot be written.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The extension is not a known format.
    #[error("the name ends in none of {known}; choose one of them ({})", path.display())]
    Format {
        /// The output.
        path: PathBuf,
        /// The writable extensions.
        known: String,
    },
    /// The file system reports an error.
    #[error("cannot write: {source}; check the permissions and the free space ({})", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The original is unreadable.
    #[error("the original of the scene cannot be read: {0}")]
    Original(#[from] ImportError),
    /// The original has other materials.
    #[error("the file has {found} materials, more than the {expected} of the scene, so the scene did not come from it; name the file that it came from ({})", path.display())]
    Foreign {
        /// The original.
        path: PathBuf,
        /// Number of its materials.
        found: usize,
        /// Number of the scene's materials.
        expected: usize,
    },
    /// Another file is at the place of a file that must be beside the output.
    #[error("there is another file where one of the scene's has to be copied; choose another folder ({})", path.display())]
    Occupied {
        /// Path of the file.
        path: PathBuf,
    },
    /// The text or JSON is invalid.
    #[error("the materials cannot be written: {reason} ({})", path.display())]
    Text {
        /// The output.
        path: PathBuf,
        /// The problem.
        reason: String,
    },
}

impl ExportError {
    pub(super) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Write { path: path.into(), source }
    }

    pub(super) fn text(path: &Path, reason: impl ToString) -> Self {
        Self::Text { path: path.into(), reason: reason.to_string() }
    }
}
