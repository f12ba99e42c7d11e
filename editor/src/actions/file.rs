//! Requests about files that are opened and saved.

use std::path::PathBuf;

/// A request about files that are opened and saved.
#[derive(Clone, Debug)]
pub enum FileAction {
    /// Open a scene, a dataset or a session.
    Open(Option<PathBuf>),
    /// Open a bundled scene, by its place in the menu.
    OpenBundled(usize),
    /// Write the session.
    Save,
    /// Write the session under another name.
    SaveAs(Option<PathBuf>),
    /// Look for files that moved, in this folder.
    Relink(Option<PathBuf>),
}

impl FileAction {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::Open(path) | Self::SaveAs(path) | Self::Relink(path) => Some(path),
            _ => None,
        }
    }
}
