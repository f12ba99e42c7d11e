//! Materials of a scene for other programs, from the window and the command line alike.

use crate::outputs::CommandFiles;
use anyhow::Result;
use lapidary_core::scene::Scene;
use lapidary_interchange::{
    export::{ExportOptions, Exported, pictures_beside, write_materials},
    materialx::Surface,
};
use std::path::{Path, PathBuf};

/// A file of materials that is to be written.
#[derive(Clone, Debug)]
pub struct MaterialExport {
    /// The file; its ending names the format.
    pub path: PathBuf,
    /// The surface of a MaterialX document.
    pub surface: Surface,
    /// The glTF file that the scene came from.
    pub original: Option<PathBuf>,
}

impl MaterialExport {
    /// What it reads and writes beside `files`.
    #[must_use]
    pub fn files(&self, files: CommandFiles) -> CommandFiles {
        files.reads(&self.original).writes([&self.path]).completes(&pictures_beside(&self.path), ["*"])
    }

    /// Writes the materials of a scene.
    ///
    /// # Errors
    /// A format that is none, an original that cannot be read or holds other materials, or a file that cannot be written.
    pub fn write(&self, scene: &Scene) -> Result<Exported> {
        let options = ExportOptions { surface: self.surface, original: self.original.as_deref() };
        Ok(write_materials(scene, &self.path, &options)?)
    }
}

/// What was written, in a line.
pub fn summary(exported: &Exported, path: &Path) -> String {
    let others = exported.files.len().saturating_sub(1);
    format!("{}: {} materials, {others} files beside it", path.display(), exported.materials)
}
