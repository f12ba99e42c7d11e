//! Why a session cannot be read or written.

use super::VERSION;
use std::{fmt, path::PathBuf};

/// Why a session cannot be read or written. Paths come last.
#[derive(Debug)]
pub enum SessionError {
    /// The file system refused.
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Larger than any session can be.
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// Bytes that are read at most.
        limit: u64,
    },
    /// Invalid JSON; the reason has line and column.
    Damaged {
        /// Which file.
        path: PathBuf,
        /// The error and its place.
        source: serde_json::Error,
    },
    /// JSON, but not a session.
    Foreign {
        /// Which file.
        path: PathBuf,
    },
    /// Written by a later version of Lapidary.
    Newer {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { action, path, source } => write!(
                f,
                "cannot {action} the session: {source}; check the path, the permissions and the free space ({})",
                path.display()
            ),
            Self::TooLarge { path, bytes, limit } => write!(
                f,
                "the file has {} MB, sessions are read up to {} MB; open a file that Lapidary saved ({})",
                bytes >> 20,
                limit >> 20,
                path.display()
            ),
            Self::Damaged { path, source } => write!(
                f,
                "the session is damaged: {source}; correct it in a text editor or open an older copy ({})",
                path.display()
            ),
            Self::Foreign { path } => {
                write!(f, "not a session file; open a file that Lapidary saved ({})", path.display())
            }
            Self::Newer { path, found } => write!(
                f,
                "the session has version {found}, this program reads up to {VERSION}; update Lapidary to open it ({})",
                path.display()
            ),
        }
    }
}

impl std::error::Error for SessionError {}
