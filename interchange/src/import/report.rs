//! Options, report and errors of an import.

use crate::{materialx::MaterialXError, names::listed};
use lapidary_core::{image::ImageError, mesh::MeshError};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file cannot be imported.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The file system reports an error.
    #[error("cannot read the file: {source}; check the path and the permissions ({})", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The contents are damaged, truncated or of a foreign format.
    #[error("the file cannot be read as {format}: {reason}; export it again ({})", path.display())]
    Parse {
        /// Path of the file.
        path: PathBuf,
        /// The format assumed.
        format: &'static str,
        /// The problem and its place.
        reason: String,
    },
    /// The extension is not a readable format.
    #[error("files that end in \".{extension}\" cannot be imported; export the scene as {known} ({})", path.display())]
    Unsupported {
        /// Path of the file.
        path: PathBuf,
        /// Its extension.
        extension: String,
        /// The readable extensions.
        known: String,
    },
    /// The mesh cannot be repaired.
    #[error("{source} ({})", path.display())]
    Mesh {
        /// Path of the file.
        path: PathBuf,
        /// The problem of the mesh.
        source: MeshError,
    },
    /// It requires unsupported extensions of its format.
    #[error("the file needs the glTF extensions {}, which are not read; export it without them ({})", listed(names), path.display())]
    Extensions {
        /// Path of the file.
        path: PathBuf,
        /// The extensions.
        names: Vec<String>,
    },
    /// It has no variant of this name.
    #[error("the scene has no material variant \"{name}\"; it has {} ({})", if known.is_empty() { "none".into() } else { listed(known) }, path.display())]
    NoSuchVariant {
        /// Path of the file.
        path: PathBuf,
        /// The requested name.
        name: String,
        /// Names of its variants.
        known: Vec<String>,
    },
    /// It has no scene of this name or number.
    #[error("the file has no scene \"{name}\"; it has {}, also by number from 0 ({})", if known.is_empty() { "none".into() } else { listed(known) }, path.display())]
    NoSuchScene {
        /// Path of the file.
        path: PathBuf,
        /// The requested name or number.
        name: String,
        /// Names of its scenes.
        known: Vec<String>,
    },
    /// It is glTF of another version.
    #[error("the file is glTF {version}, and only glTF 2.0 is read; export it as glTF 2.0, or convert it with the program gltf-pipeline ({})", path.display())]
    GltfVersion {
        /// Path of the file.
        path: PathBuf,
        /// Its version.
        version: String,
    },
    /// The scene exceeds a limit.
    #[error("the scene has {count} {what}, more than the limit of {limit}; reduce it or split it up ({})", path.display())]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// The things that exceed the limit.
        what: &'static str,
        /// Their number.
        count: u64,
        /// The allowed number.
        limit: u64,
    },
    /// The scene exceeds the free memory.
    #[error("the scene takes about {needed} MB of memory, but {available} MB are free; reduce its textures or its meshes, or close other programs ({})", path.display())]
    Memory {
        /// Path of the file.
        path: PathBuf,
        /// Estimated memory, in megabytes.
        needed: u64,
        /// Allowed memory, in megabytes.
        available: u64,
    },
    /// The file needs others outside its folder.
    #[error("the files {} are outside the folder of the file that needs them, and were not read; put them beside it, or allow files outside the folder ({})", listed(names), path.display())]
    Outside {
        /// Path of the file.
        path: PathBuf,
        /// The files, as named in it.
        names: Vec<String>,
    },
    /// A document of several materials has none of the requested name.
    #[error("{source} ({})", path.display())]
    NoSuchMaterial {
        /// Path of the file.
        path: PathBuf,
        /// The requested name and the existing ones.
        source: MaterialXError,
    },
    /// A picture of a material is unreadable.
    #[error("a map of the material cannot be read: {source} ({})", path.display())]
    Map {
        /// Path of the material file.
        path: PathBuf,
        /// The problem of the picture.
        source: ImageError,
    },
}

impl ImportError {
    /// The error of a missing scene.
    pub(super) fn no_scene(path: &Path, wanted: Option<&str>, known: Vec<String>) -> Self {
        Self::NoSuchScene { path: path.into(), name: wanted.unwrap_or_default().into(), known }
    }

    /// The error of a missing variant.
    pub(super) fn no_variant(path: &Path, wanted: Option<&str>, known: Vec<String>) -> Self {
        Self::NoSuchVariant { path: path.into(), name: wanted.unwrap_or_default().into(), known }
    }
}

/// Options of an import.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ImportOptions {
    /// Largest memory in bytes; `None` allows the free memory.
    pub budget: Option<u64>,
    /// Whether files outside the folder of the scene or material are read.
    pub allow_outside: bool,
    /// The shown variant of a glTF file's materials; `None` shows the file's default.
    pub variant: Option<String>,
    /// The imported scene of a glTF file, by name or number from 0; `None` imports the file's default.
    pub scene: Option<String>,
}

/// Report of an import and its repairs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ImportReport {
    /// Vertices of the imported mesh.
    pub vertices: usize,
    /// Triangles of the imported mesh.
    pub triangles: usize,
    /// Dropped triangles without an area.
    pub degenerate_triangles: usize,
    /// Removed vertices that equalled others in all attributes.
    pub welded_vertices: usize,
    /// Vertices added at creases and at seams of mirrored texture coordinates.
    pub split_vertices: usize,
    /// Dropped vertices that no triangle used.
    pub unreferenced_vertices: usize,
    /// Vertices with missing or invalid normals, computed from the faces.
    pub normals_rebuilt: usize,
    /// Vertices with missing or invalid tangents, computed anew.
    pub tangents_rebuilt: usize,
    /// Vertices without texture coordinates, set by a box projection of one unit per meter.
    pub uvs_projected: usize,
    /// Triangles whose winding was reversed because all their normals were on their back.
    pub flipped_triangles: usize,
    /// Names of the scenes of its file, if it has several; one of them is imported.
    pub scenes: Vec<String>,
    /// The one of them that is imported by default.
    pub default_scene: Option<String>,
    /// Names of the variants of its materials.
    pub variants: Vec<String>,
    /// Files read in addition to the scene's: buffers, materials and pictures.
    pub files: Vec<PathBuf>,
    /// Files outside the folder of the scene, as named in it. They are read only if allowed.
    pub outside: Vec<String>,
    /// Other problems, with repair and remedy.
    pub warnings: Vec<String>,
    /// The warnings about missing, damaged or disallowed pictures and material libraries.
    #[serde(skip)]
    pub unread: Vec<String>,
}
