//! Exports a scene's materials for other programs, from the window and the command line.

use crate::outputs::CommandFiles;
use anyhow::Result;
use lapidary_core::scene::Scene;
use lapidary_interchange::{
    export::{ExportOptions, Exported, pictures_beside, write_materials},
    materialx::Surface,
};
use std::path::{Path, PathBuf};

/// A file of materials to write.
#[derive(Clone, Debug)]
pub struct MaterialExport {
    /// The file; its extension selects the format.
    pub path: PathBuf,
    /// The surface of a MaterialX document.
    pub surface: Surface,
    /// The glTF file that the scene came from.
    pub original: Option<PathBuf>,
    /// The scene of that file, by name or number; `None` for its default.
    pub scene: Option<String>,
}

impl MaterialExport {
    /// Adds the files that it reads and writes to `files`.
    #[must_use]
    pub fn files(&self, files: CommandFiles) -> CommandFiles {
        files.reads(&self.original).writes([&self.path]).completes(&pictures_beside(&self.path), ["*"])
    }

    /// Writes the materials of a scene.
    ///
    /// # Errors
    /// An unknown format, an original that cannot be read or has other materials, or an unwritable file.
    pub fn write(&self, scene: &Scene) -> Result<Exported> {
        let (original, in_file) = (self.original.as_deref(), self.scene.as_deref());
        let options = ExportOptions { surface: self.surface, original, scene: in_file };
        // Hidden objects belong to the file too.
        let scene = scene.with_all_shown();
        Ok(write_materials(&scene, &self.path, &options)?)
    }
}

/// A one-line summary of the written files.
pub fn summary(exported: &Exported, path: &Path) -> String {
    let others = exported.files.len().saturating_sub(1);
    format!("{}: {} materials, {others} files beside it", path.display(), exported.materials)
}
