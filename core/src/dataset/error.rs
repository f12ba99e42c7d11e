//! Errors of writing and reading a dataset.

use crate::{
    bounds::MOST_COORDINATE,
    brdf::BrdfFileError,
    camera::field_of_view_range,
    cut::CutError,
    image::ImageError,
    lights::{LightProblem, MAX_LIGHTS},
    material::MaterialProblem,
    mesh::MeshError,
};
use std::{
    error::Error,
    path::{Path, PathBuf},
};
use thiserror::Error;

/// Why a dataset cannot be written or read. Paths come last.
#[derive(Debug, Error)]
pub enum DatasetError {
    /// The file system reports an error.
    #[error("cannot {action} the dataset: {source}; check the path, the permissions and the free space ({})", path.display())]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Not a safetensors file, or a truncated one.
    #[error("the file is not a dataset, or was cut short ({reason}); bake the scene again with `lapidary bake` ({})", path.display())]
    Foreign {
        /// Path of the file.
        path: PathBuf,
        /// The problem.
        reason: String,
    },
    /// Written by a later version of Lapidary.
    #[error("the dataset has format version {found}, this program reads up to {supported}; update Lapidary or bake again ({})", path.display())]
    Newer {
        /// Path of the file.
        path: PathBuf,
        /// Version of the file.
        found: u32,
        /// The newest supported version.
        supported: u32,
    },
    /// The contents are invalid, so no program could read or use them.
    #[error("the dataset cannot be written: {reason}; correct the scene or the settings, and bake again ({})", path.display())]
    Unwritable {
        /// Path of the file.
        path: PathBuf,
        /// The problem.
        reason: Damage,
    },
    /// There is too little memory for a picture in the file.
    #[error("a picture in the dataset takes {needed} MB of memory, but {available} MB are free; close other programs ({})", path.display())]
    Memory {
        /// Path of the file.
        path: PathBuf,
        /// Memory for the picture, in megabytes.
        needed: u64,
        /// Free memory, in megabytes.
        available: u64,
    },
    /// The contents contradict themselves.
    #[error("the dataset is damaged: {reason}; copy it again from its source or bake again ({})", path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// The problem.
        reason: Damage,
    },
}

impl DatasetError {
    /// The error for a file at `path` with unreadable contents.
    pub(super) fn of_contents(path: &Path, reason: Damage) -> Self {
        match reason {
            Damage::Picture { source: ImageError::Memory { needed, available, .. }, .. } => {
                Self::Memory { path: path.into(), needed, available }
            }
            Damage::Unreadable { source, .. } => Self::Io { action: "read", path: path.into(), source },
            reason => Self::Damaged { path: path.into(), reason },
        }
    }
}

/// Errors inside a dataset.
#[derive(Debug, Error)]
pub enum Damage {
    /// A tensor is missing.
    #[error("tensor `{0}` is missing")]
    Missing(String),
    /// A tensor has the wrong type or shape.
    #[error("tensor `{name}` is {found}, not {expected}")]
    Shape {
        /// Name of the tensor.
        name: String,
        /// Its type and shape.
        found: String,
        /// The expected type and shape.
        expected: String,
    },
    /// The bytes differ from the written ones.
    #[error("tensor `{0}` does not match its checksum")]
    Checksum(String),
    /// The file system cannot read a tensor, or the file was shortened meanwhile.
    #[error("tensor `{name}` cannot be read: {source}")]
    Unreadable {
        /// Name of the tensor.
        name: String,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Opacities of parts refer to missing objects or materials.
    #[error("parts that let light through do not fit its objects and materials")]
    PartOpacities,
    /// Placed objects are missing or have no valid pose.
    #[error("its moved or deformed objects do not match its objects")]
    Placed,
    /// Variants refer to missing objects or materials.
    #[error("its variants do not fit its objects and materials")]
    Variants,
    /// The mesh is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A cut is invalid.
    #[error("entry {index} of `{cuts}` is invalid: {source}")]
    Cut {
        /// Name of the tensor.
        cuts: &'static str,
        /// Index of the vertex or surface source.
        index: usize,
        /// The cause.
        source: CutError,
    },
    /// A list has the wrong length.
    #[error("there are {found} {what}, not {expected}")]
    Count {
        /// The counted things.
        what: &'static str,
        /// Their number.
        found: usize,
        /// The expected number.
        expected: usize,
    },
    /// A tensor has no checksum.
    #[error("tensor `{0}` has no checksum")]
    NoChecksum(String),
    /// A setting of the bake is out of range.
    #[error("the setting {0} of its bake is not a finite number in its range")]
    Setting(&'static str),
    /// The tree order is not a permutation of a power of two.
    #[error("the order of the light tree is no permutation of 2^H samples")]
    Tree,
    /// The stored data of a bake part is invalid.
    #[error(transparent)]
    Part(Box<dyn Error + Send + Sync>),
    /// A material refers to a missing texture.
    #[error("material `{material}` refers to texture {texture}, but there are {count}")]
    Texture {
        /// Name of the material.
        material: String,
        /// The index.
        texture: u32,
        /// Number of textures.
        count: usize,
    },
    /// A material has an invalid number.
    #[error("material {index} (`{name}`) is invalid: {source}")]
    Material {
        /// Index of the material, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// The problem.
        source: MaterialProblem,
    },
    /// More local lights than allowed.
    #[error("there are {0} lights, more than the limit of {MAX_LIGHTS}")]
    Lights(usize),
    /// A local light is invalid.
    #[error("light {index} (`{name}`) is invalid: {source}")]
    Light {
        /// Index of the light, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// The cause.
        source: LightProblem,
    },
    /// A camera is invalid.
    #[error(
        "camera {index} (`{name}`) has a position or a direction that is not a finite number within {MOST_COORDINATE} m, or a field of \
         view that is not {}",
        field_of_view_range()
    )]
    Camera {
        /// Index of the camera, from 0.
        index: usize,
        /// Its name.
        name: String,
    },
    /// A picture is unreadable.
    #[error("texture {index} cannot be read: {source}")]
    Picture {
        /// Index of the texture, from 0.
        index: usize,
        /// The cause.
        source: ImageError,
    },
    /// A BRDF file is unusable.
    #[error("BRDF {index} cannot be read: {source}")]
    Brdf {
        /// Index of the file, from 0.
        index: usize,
        /// The cause.
        source: BrdfFileError,
    },
    /// A material refers to a missing BRDF.
    #[error("material `{material}` refers to BRDF {index}, but there are {count}")]
    NoBrdf {
        /// Name of the material.
        material: String,
        /// The index.
        index: u32,
        /// Number of files.
        count: usize,
    },
    /// The metadata is unreadable.
    #[error("the metadata cannot be read ({0})")]
    Metadata(String),
}

impl Damage {
    /// Wraps an error of a bake part.
    pub(super) fn of_part(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Part(Box::new(error))
    }
}

/// Errors of a surface point.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SurfelDamage {
    /// Its position is invalid.
    #[error("has a position that is not a finite number within {MOST_COORDINATE} m of the origin")]
    Position,
    /// Its normal is invalid.
    #[error("has a normal that is not of length 1")]
    Normal,
    /// Its triangle is missing.
    #[error("lies on triangle {triangle}, but there are {count}")]
    Triangle {
        /// Its triangle.
        triangle: u32,
        /// Number of triangles.
        count: usize,
    },
    /// Its barycentric weights are invalid.
    #[error("has a place on its triangle that is not a finite number from 0 to 1")]
    Place,
}
