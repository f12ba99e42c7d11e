//! Exports the materials of a scene to other programs' formats: MaterialX, MTL, and glTF.
//!
//! | format | contents |
//! |---|---|
//! | `.mtlx` | all materials as one MaterialX document, and their pictures in a folder beside it |
//! | `.mtl` | a library of materials with the PBR keys that Blender and others have, and the pictures beside it |
//! | `.gltf`, `.glb` | the file that the scene came from with its materials rewritten, or meshes and materials alone |
//!
//! Each writer reports the features that its format lacks. Everything written reads back unchanged, within 1e-6.

mod error;
mod gltf;
mod material_format;
mod mtl;
mod patterns;
mod pictures;
#[cfg(test)]
mod tests;

pub use error::{ExportError, Exported};
pub use pictures::pictures_beside;

use crate::{
    file_format::{FileFormat, listed},
    material_file::MaterialFile,
    materialx::{self, Surface},
};
use lapidary_core::{output::write_atomically, scene::Scene};
pub use material_format::MaterialFormat;
use pictures::PictureFolder;
use std::path::Path;

/// Extensions of the writable files.
pub fn endings() -> Vec<&'static str> {
    MaterialFormat::all_endings(MaterialFormat::exports)
}

/// Options of an export.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExportOptions<'a> {
    /// The surface of a MaterialX document.
    pub surface: Surface,
    /// The glTF file that the scene was imported from: its materials are rewritten, all else stays. Without it, a glTF
    /// file has the meshes and materials of the scene.
    pub original: Option<&'a Path>,
    /// The scene of that file, by name or number; `None` for its default.
    pub scene: Option<&'a str>,
}

/// Writes the materials of a scene, except its ground's, in the format given by the extension of `path`.
///
/// # Errors
/// See [`ExportError`].
pub fn write_materials(scene: &Scene, path: &Path, options: &ExportOptions) -> Result<Exported, ExportError> {
    let write = MaterialFormat::of(path).and_then(|format| format.export);
    let write = write.ok_or_else(|| ExportError::Format { path: path.into(), known: listed(&endings(), " and ") })?;
    write(&patterns::as_pictures(scene), path, options)
}

fn write_materialx(scene: &Scene, path: &Path, options: &ExportOptions) -> Result<Exported, ExportError> {
    let (materials, exported) = with_pictures(scene, path)?;
    let written = materialx::write(&materials, options.surface).map_err(|error| ExportError::text(path, error))?;
    finished(exported, path, &written.text, written.remarks)
}

fn write_library(scene: &Scene, path: &Path, _: &ExportOptions) -> Result<Exported, ExportError> {
    let (materials, exported) = with_pictures(scene, path)?;
    let mut remarks = Vec::new();
    let text = mtl::library(&materials, &mut remarks);
    finished(exported, path, &text, remarks)
}

fn finished(exported: Exported, path: &Path, text: &str, remarks: Vec<String>) -> Result<Exported, ExportError> {
    write_atomically(path, text.as_bytes()).map_err(ExportError::write(path))?;
    let files = [vec![path.to_owned()], exported.files].concat();
    Ok(Exported { files, remarks: [exported.remarks, remarks].concat(), ..exported })
}

/// The materials with maps that name pictures. Writes the pictures beside `path`.
fn with_pictures(scene: &Scene, path: &Path) -> Result<(Vec<MaterialFile>, Exported), ExportError> {
    let ground = scene.mesh.ground_material();
    let materials = (0..).zip(&scene.materials).filter(|(index, _)| Some(*index) != ground);
    let mut folder = PictureFolder::beside(path, &scene.textures);
    let materials: Vec<MaterialFile> =
        materials.map(|(_, material)| folder.material(material)).collect::<Result<_, _>>()?;
    let PictureFolder { files, remarks, .. } = folder;
    let count = materials.len();
    Ok((materials, Exported { files, materials: count, remarks }))
}
