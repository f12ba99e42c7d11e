//! The materials of a scene, back in the formats of other programs: MaterialX, MTL, and glTF.
//!
//! | format | what is written |
//! |---|---|
//! | `.mtlx` | all materials as one MaterialX document, and their pictures in a folder beside it |
//! | `.mtl` | a library of materials with the PBR keys that Blender and others have, and the pictures beside it |
//! | `.gltf`, `.glb` | the file that the scene came from with its materials written anew, or meshes and materials alone |
//!
//! Each writer says what its format does not hold. What it holds is read again as it was, within 1e-6.

mod gltf;
mod material_format;
mod mtl;
mod patterns;
mod pictures;
#[cfg(test)]
mod tests;

use crate::{
    formats::{self, FileFormat},
    import::{ImportError, MaterialFile},
    materialx::{self, Surface},
};
use lapidary_core::{output::write_atomically, scene::Scene};
pub use material_format::MaterialFormat;
use pictures::PictureFolder;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Endings of the files that can be written.
pub fn endings() -> Vec<&'static str> {
    MaterialFormat::all_endings(MaterialFormat::exports)
}

/// How materials are written.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExportOptions<'a> {
    /// The surface of a MaterialX document.
    pub surface: Surface,
    /// The glTF file that the scene was imported from: its materials are written anew, all else stays. Without it, a glTF file has
    /// the meshes and materials of the scene.
    pub original: Option<&'a Path>,
}

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
    #[error("the name ends in none of {}; choose one of them ({})", formats::listed(&endings(), " and "), path.display())]
    Format {
        /// The output.
        path: PathBuf,
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
    fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Write { path: path.into(), source }
    }

    fn text(path: &Path, reason: impl ToString) -> Self {
        Self::Text { path: path.into(), reason: reason.to_string() }
    }
}

/// The folder beside a file of materials that takes their pictures.
pub fn pictures_beside(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-maps"))
}

/// Writes the materials of a scene, but that of its ground, in the format that the ending of `path` names.
///
/// # Errors
/// See [`ExportError`].
pub fn write_materials(scene: &Scene, path: &Path, options: &ExportOptions) -> Result<Exported, ExportError> {
    let write = MaterialFormat::of(path).and_then(|format| format.export);
    let write = write.ok_or_else(|| ExportError::Format { path: path.into() })?;
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

/// The materials with maps that name pictures, which are written beside `path`.
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
