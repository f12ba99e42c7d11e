//! Requests about environments and their library.

use std::path::PathBuf;

/// A request about environments and their library.
#[derive(Clone, Debug)]
pub enum EnvironmentAction {
    /// Light the scene by a map.
    Load(Option<PathBuf>),
    /// Add maps to the library of environments.
    AddToLibrary(Option<PathBuf>),
}

impl EnvironmentAction {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::Load(path) | Self::AddToLibrary(path) => Some(path),
        }
    }
}
