//! Import of files of scenes into a [`Scene`], with a report of what was repaired.
//!
//! Each format has one reader that returns a `RawMesh` with the contents of the file. `repair` then makes one clean
//! mesh of it, the same way for all formats. `ranges` keeps all else in range. Contents of a file never cause a panic:
//! they are repaired with a warning, or refused with an error. `budget` bounds the memory that they take, and `files` what
//! they may read.

use crate::{formats::FileFormat, materialx::MaterialXError};
use files::Files;
use glam::Vec3;
pub(crate) use gltf::percent_decoded;
use lapidary_core::{
    animation::Animation,
    camera::Camera,
    image::ImageError,
    input,
    lights::Light,
    material::Material,
    parts::Variants,
    scene::{MeshError, Object, Scene},
    texture::Texture,
};
use repair::RawMesh;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

mod budget;
mod files;
mod gltf;
mod material_file;
pub(crate) mod mtl;
mod obj;
mod ply;
mod ranges;
mod repair;
mod scene_format;
mod tangents;
mod textures;

pub use material_file::{
    MapFiles, MaterialFile, SlotFile, is_materialx, load_material, material_in_file, materials_in_file,
    pictures_of_material,
};

pub use scene_format::{Content, SceneFormat};

/// Files with more vertices or triangles than this are refused: at some 100 bytes each they would take 10 GB.
const MAX_ELEMENTS: u64 = 100_000_000;

/// Why a file could not be imported.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The file system refused.
    #[error("cannot read the file: {source}; check the path and the permissions ({})", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The contents are damaged, truncated or of a foreign format.
    #[error("the file cannot be read as {format}: {reason}; export it again ({})", path.display())]
    Parse {
        /// Which file.
        path: PathBuf,
        /// The format assumed.
        format: &'static str,
        /// What is wrong, and where.
        reason: String,
    },
    /// The extension names no format that can be read.
    #[error("files that end in \".{extension}\" cannot be imported; export the scene as {} ({})", SceneFormat::names(), path.display())]
    Unsupported {
        /// Which file.
        path: PathBuf,
        /// Its extension.
        extension: String,
    },
    /// The mesh cannot be repaired.
    #[error("{source} ({})", path.display())]
    Mesh {
        /// Which file.
        path: PathBuf,
        /// What is wrong with the mesh.
        source: MeshError,
    },
    /// It needs extensions of its format that are not read.
    #[error("the file needs the glTF extensions {}, which are not read; export it without them ({})", listed(names), path.display())]
    Extensions {
        /// Which file.
        path: PathBuf,
        /// The extensions.
        names: Vec<String>,
    },
    /// It has no variant of that name.
    #[error("the scene has no material variant \"{name}\"; it has {} ({})", if known.is_empty() { "none".into() } else { listed(known) }, path.display())]
    NoSuchVariant {
        /// Which file.
        path: PathBuf,
        /// What was asked for.
        name: String,
        /// Those that it has.
        known: Vec<String>,
    },
    /// The scene would not fit in memory.
    #[error("the scene has {count} {what}, more than the limit of {limit}; reduce it or split it up ({})", path.display())]
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: u64,
        /// How many are allowed.
        limit: u64,
    },
    /// The scene would not fit in the memory that is free.
    #[error("the scene takes about {needed} MB of memory, but {available} MB are free; reduce its textures or its meshes, or close other programs ({})", path.display())]
    Memory {
        /// Which file.
        path: PathBuf,
        /// What it takes as far as it was estimated, in megabytes.
        needed: u64,
        /// What it may take, in megabytes.
        available: u64,
    },
    /// The file needs others that it may not read.
    #[error("the files {} are outside the folder of the file that needs them, and were not read; put them beside it, or allow files outside the folder ({})", listed(names), path.display())]
    Outside {
        /// Which file.
        path: PathBuf,
        /// The files, as it names them.
        names: Vec<String>,
    },
    /// A document of several materials has none of the name that was asked for.
    #[error("{source} ({})", path.display())]
    NoSuchMaterial {
        /// Which file.
        path: PathBuf,
        /// What was asked for, and what there is.
        source: MaterialXError,
    },
    /// A picture that a material names cannot be read.
    #[error("a map of the material cannot be read: {source} ({})", path.display())]
    Map {
        /// The material file.
        path: PathBuf,
        /// What is wrong with the picture.
        source: ImageError,
    },
}

/// What an import may take and read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ImportOptions {
    /// Most memory in bytes; without it, what is free.
    pub budget: Option<u64>,
    /// Whether files outside the folder of the scene or the material are read.
    pub allow_outside: bool,
    /// The variant of a glTF file's materials that is shown; without it, those that the file shows first.
    pub variant: Option<String>,
}

/// Report of an import and its repairs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ImportReport {
    /// Vertices of the imported mesh.
    pub vertices: usize,
    /// Triangles of the imported mesh.
    pub triangles: usize,
    /// Triangles without an area that were dropped.
    pub degenerate_triangles: usize,
    /// Number of vertices in use that were removed because they equalled others in all attributes.
    pub welded_vertices: usize,
    /// Number of vertices that were added at creases and at seams of mirrored texture coordinates.
    pub split_vertices: usize,
    /// Vertices that no triangle used and that were dropped.
    pub unreferenced_vertices: usize,
    /// Vertices whose normals were missing or invalid and were computed from the faces.
    pub normals_rebuilt: usize,
    /// Vertices whose tangents were missing or invalid and were computed.
    pub tangents_rebuilt: usize,
    /// Vertices without texture coordinates, which took them from a box projection of one unit per metre.
    pub uvs_projected: usize,
    /// Triangles whose winding was reversed because all their normals were on their back.
    pub flipped_triangles: usize,
    /// Names of the variants of its materials.
    pub variants: Vec<String>,
    /// Files that were read beside that of the scene: buffers, materials and pictures.
    pub files: Vec<PathBuf>,
    /// Files outside the folder of the scene, as it names them. They were read only if that was allowed.
    pub outside: Vec<String>,
    /// Other problems, with their repair and the remedy.
    pub warnings: Vec<String>,
    /// Those of the warnings that tell of a picture or a material library that is missing, damaged or not allowed.
    #[serde(skip)]
    pub unread: Vec<String>,
}

/// A scene and the report of its import.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The scene; its mesh is valid.
    pub scene: Scene,
    /// Report of the import and its repairs.
    pub report: ImportReport,
}

/// Output of the reader of one format.
#[derive(Default)]
struct Source {
    mesh: RawMesh,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    objects: Vec<Object>,
    cameras: Vec<Camera>,
    lights: Vec<Light>,
    variants: Variants,
    warnings: Vec<String>,
    unread: Vec<String>,
    outside: Vec<String>,
    files: Vec<PathBuf>,
}

/// Imports the scene in a file of one of the [`SceneFormat`]s. It may take all free memory, and read files of its folder.
///
/// # Errors
/// Those of [`import_with`].
pub fn import(path: &Path) -> Result<Imported, ImportError> {
    import_with(path, &ImportOptions::default())
}

/// Imports the scene in a file of one of the [`SceneFormat`]s.
///
/// # Errors
/// A file that cannot be read, is damaged, is too large, holds no triangles, or needs files that it may not read.
pub fn import_with(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let Some(format) = SceneFormat::of(path) else {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        return Err(ImportError::Unsupported { path: path.into(), extension });
    };
    let variant = options.variant.as_deref();
    if !format.holds(Content::Variants) && variant.is_some() {
        return Err(gltf::no_variant(path, variant, Vec::new()));
    }
    let mut files = Files::beside(path, options);
    let bytes = read_file(path, &mut files)?;
    finish((format.read)(&bytes, path, files, variant)?, path)
}

/// What moves in a file; none of a format without animations.
pub(crate) fn animation(path: &Path, options: &ImportOptions) -> Option<Result<Animation, ImportError>> {
    let read = SceneFormat::of(path)?.animation?;
    let mut files = Files::beside(path, options);
    Some(read_file(path, &mut files).and_then(|bytes| read(&bytes, path, files)))
}

fn read_file(path: &Path, files: &mut Files) -> Result<Vec<u8>, ImportError> {
    let bytes = input::read(path).map_err(|source| ImportError::Io { path: path.into(), source })?;
    files.budget.take(bytes.len() as u64).map_err(|over| over.at(path))?;
    Ok(bytes)
}

/// Repairs the mesh, and checks that it is valid.
fn finish(source: Source, path: &Path) -> Result<Imported, ImportError> {
    let mesh_error = |source| ImportError::Mesh { path: path.into(), source };
    let Source { variants, warnings, unread, outside, files, .. } = source;
    let names = variants.names.clone();
    let mut report = ImportReport { variants: names, warnings, unread, outside, files, ..Default::default() };
    let mesh = repair::repair(source.mesh, &mut report).map_err(mesh_error)?;
    mesh.validate(source.materials.len(), source.objects.len()).map_err(mesh_error)?;
    let mut scene = Scene {
        mesh,
        materials: source.materials,
        textures: source.textures.into_iter().map(Into::into).collect(),
        objects: source.objects,
        cameras: source.cameras,
        lights: source.lights,
        variants,
        part_opacities: Vec::new(),
        placed: Vec::new(),
        clip_time: None,
    };
    aim_at_the_center(&mut scene);
    ranges::keep_in_range(&mut scene, &mut report.warnings);
    Ok(Imported { scene, report })
}

/// Moves the targets of cameras and lights along their axes to the depth of the scene's centre, so that orbiting turns
/// about it and handles lie in the scene.
fn aim_at_the_center(scene: &mut Scene) {
    let bounds = scene.mesh.bounds();
    let aimed = |from: Vec3, target: Vec3| {
        let forward = (target - from).normalize_or(Vec3::NEG_Z);
        let depth = (bounds.center() - from).dot(forward);
        from + forward * if depth > 0.0 { depth } else { bounds.diagonal() }
    };
    for camera in &mut scene.cameras {
        camera.target = aimed(camera.eye, camera.target);
    }
    for light in scene.lights.iter_mut().filter(|light| light.emission.is_aimed()) {
        light.target = aimed(light.position, light.target);
    }
}

fn check_count(what: &'static str, count: u64, path: &Path) -> Result<(), ImportError> {
    if count <= MAX_ELEMENTS {
        return Ok(());
    }
    Err(ImportError::TooLarge { path: path.into(), what, count, limit: MAX_ELEMENTS })
}

/// Names for a warning: a few of them, and how many more there are.
pub(crate) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 5;
    let shown = names.iter().take(SHOWN).map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN { format!("{shown} and {} more", names.len() - SHOWN) } else { shown }
}
