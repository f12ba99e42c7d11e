//! Requests about the comparison with a reference.

use std::path::PathBuf;

/// A request about the comparison with a reference.
#[derive(Clone, Debug)]
pub enum CompareAction {
    /// Begin or end the comparison with a reference.
    Toggle,
    /// Compare with a picture file.
    Reference(Option<PathBuf>),
    /// Hold the tracing of the reference, or go on.
    Pause(bool),
}

impl CompareAction {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::Reference(path) => Some(path),
            _ => None,
        }
    }
}
