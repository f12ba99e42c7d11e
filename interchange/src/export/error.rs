//! What an export wrote, and why it could not.

use crate::import::ImportError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What was written.
#[derive(Clone, Debug, Default)]
pub struct Exported {
    /// The files, the one that was asked for first.
    pub files: Vec<PathBuf>,
    /// Materials in it.
    pub materials: usize,
    /// What the format does not hold, in sentences.
    pub remarks: Vec<String>,
}

/// Why materials were not written.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The ending names no format.
    #[error("the name ends in none of {known}; choose one of them ({})", path.display())]
    Format {
        /// The output.
        path: PathBuf,
        /// The endings that can be written.
        known: String,
    },
    /// The file system refused.
    #[error("cannot write: {source}; check the permissions and the free space ({})", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The original cannot be read.
    #[error("the original of the scene cannot be read: {0}")]
    Original(#[from] ImportError),
    /// The original holds other materials.
    #[error("the file has {found} materials, more than the {expected} of the scene, so the scene did not come from it; name the file that it came from ({})", path.display())]
    Foreign {
        /// The original.
        path: PathBuf,
        /// How many it has.
        found: usize,
        /// How many the scene has.
        expected: usize,
    },
    /// A file that has to lie beside the output is another there.
    #[error("there is another file where one of the scene's has to be copied; choose another folder ({})", path.display())]
    Occupied {
        /// Which.
        path: PathBuf,
    },
    /// Text that is no text, or JSON that is none.
    #[error("the materials cannot be written: {reason} ({})", path.display())]
    Text {
        /// The output.
        path: PathBuf,
        /// What went wrong.
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
