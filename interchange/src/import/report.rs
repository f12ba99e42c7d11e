//! What an import may take and read, what it reports, and why it fails.

use crate::{materialx::MaterialXError, names::listed};
use lapidary_core::{image::ImageError, mesh::MeshError};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

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
    #[error("files that end in \".{extension}\" cannot be imported; export the scene as {known} ({})", path.display())]
    Unsupported {
        /// Which file.
        path: PathBuf,
        /// Its extension.
        extension: String,
        /// The endings that can be imported.
        known: String,
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

impl ImportError {
    /// The error of a variant that is not there.
    pub(super) fn no_variant(path: &Path, wanted: Option<&str>, known: Vec<String>) -> Self {
        Self::NoSuchVariant { path: path.into(), name: wanted.unwrap_or_default().into(), known }
    }
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
    /// Vertices without texture coordinates, which took them from a box projection of one unit per meter.
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
