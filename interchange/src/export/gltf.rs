//! glTF 2.0 files with the materials of a scene.

mod compose;
mod container;
mod materials;
mod original;
mod own;

use super::{
    ExportOptions,
    error::{ExportError, Exported},
};
use lapidary_core::scene::Scene;
use std::path::Path;

pub(super) fn write(scene: &Scene, path: &Path, options: &ExportOptions) -> Result<Exported, ExportError> {
    match options.original {
        Some(original) => original::write(scene, path, original, options.scene),
        None => own::write(scene, path),
    }
}

/// A binary file from a JSON text and its data.
#[cfg(test)]
pub(super) fn glb_of(json: &str, data: Vec<u8>) -> Vec<u8> {
    container::binary(json, &container::binary_chunk(data)).unwrap()
}
