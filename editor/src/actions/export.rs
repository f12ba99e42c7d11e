//! Requests about what is written of the picture and the scene.

use std::path::PathBuf;

/// A request about what is written of the picture and the scene.
#[derive(Clone, Debug)]
pub enum ExportAction {
    /// Write the picture.
    Picture(Option<PathBuf>),
    /// Write the picture with all its layers.
    Layers(Option<PathBuf>),
    /// Write the materials in a format of other programs.
    Materials(Option<PathBuf>),
    /// Describe an image sequence to export.
    DescribeSequence,
    /// Choose the folder of the sequence that is described.
    SequenceFolder(Option<PathBuf>),
    /// Stop the export; what is complete stays.
    Cancel,
}

impl ExportAction {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::Picture(path) | Self::Layers(path) | Self::Materials(path) | Self::SequenceFolder(path) => Some(path),
            _ => None,
        }
    }
}
