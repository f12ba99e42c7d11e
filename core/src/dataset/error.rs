//! Why a dataset cannot be written or read.

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
    /// The file system refused.
    #[error("cannot {action} the dataset: {source}; check the path, the permissions and the free space ({})", path.display())]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Not a safetensors file, or a truncated one.
    #[error("the file is no dataset, or was cut short ({reason}); bake the scene again with `lapidary bake` ({})", path.display())]
    Foreign {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Written by a later version of Lapidary.
    #[error("the dataset has format version {found}, this program reads up to {supported}; update Lapidary or bake again ({})", path.display())]
    Newer {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: u32,
        /// The newest known.
        supported: u32,
    },
    /// The contents cannot be written, since nothing could read or use them.
    #[error("the dataset cannot be written: {reason}; correct the scene or the settings, and bake again ({})", path.display())]
    Unwritable {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        reason: Damage,
    },
    /// There is not enough memory for a picture in it.
    #[error("a picture in the dataset takes {needed} MB of memory, but {available} MB are free; close other programs ({})", path.display())]
    Memory {
        /// Which file.
        path: PathBuf,
        /// What the picture takes, in megabytes.
        needed: u64,
        /// What is free, in megabytes.
        available: u64,
    },
    /// The contents contradict themselves.
    #[error("the dataset is damaged: {reason}; copy it again from its source or bake again ({})", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        reason: Damage,
    },
}

impl DatasetError {
    /// The error of a file at `path` whose contents cannot be read.
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
    /// A tensor is not there.
    #[error("tensor `{0}` is missing")]
    Missing(String),
    /// A tensor has another type or shape than its owner needs.
    #[error("tensor `{name}` is {found}, not {expected}")]
    Shape {
        /// Name of the tensor.
        name: String,
        /// Type and shape found.
        found: String,
        /// Type and shape needed.
        expected: String,
    },
    /// The bytes differ from those that were written.
    #[error("tensor `{0}` does not match its checksum")]
    Checksum(String),
    /// The file system refused to read a tensor, or the file became shorter meanwhile.
    #[error("tensor `{name}` cannot be read: {source}")]
    Unreadable {
        /// Name of the tensor.
        name: String,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Opacities of parts name objects or materials that are not there.
    #[error("parts that let light through do not fit its objects and materials")]
    PartOpacities,
    /// Placed objects are not there, or have no place.
    #[error("objects that are not where their file has them do not fit its objects")]
    Placed,
    /// Variants name objects or materials that are not there.
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
        /// Which vertex or surface source.
        index: usize,
        /// Why.
        source: CutError,
    },
    /// A part has another number of elements than its owner needs.
    #[error("there are {found} {what}, not {expected}")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A tensor whose bytes cannot be checked.
    #[error("tensor `{0}` has no checksum")]
    NoChecksum(String),
    /// A setting of the bake that nothing can be computed with.
    #[error("the setting {0} of its bake is no finite number in its range")]
    Setting(&'static str),
    /// The tree order is no permutation of a power of two.
    #[error("the order of the light tree is no permutation of 2^H samples")]
    Tree,
    /// What a part of a bake has stored is invalid.
    #[error(transparent)]
    Part(Box<dyn Error + Send + Sync>),
    /// A material refers to a texture that is not there.
    #[error("material `{material}` refers to texture {texture}, but there are {count}")]
    Texture {
        /// Name of the material.
        material: String,
        /// The index.
        texture: u32,
        /// Number of textures.
        count: usize,
    },
    /// Numbers of a material.
    #[error("material {index} (`{name}`) is invalid: {source}")]
    Material {
        /// Which of the scene's materials, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        source: MaterialProblem,
    },
    /// More local lights than a scene may have.
    #[error("there are {0} lights, more than the limit of {MAX_LIGHTS}")]
    Lights(usize),
    /// A local light that cannot shine.
    #[error("light {index} (`{name}`) is invalid: {source}")]
    Light {
        /// Which of the scene's lights, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// Why.
        source: LightProblem,
    },
    /// A camera that looks nowhere.
    #[error(
        "camera {index} (`{name}`) has a place or a direction that is no finite number within {MOST_COORDINATE} m, or a field of \
         view that is not {}",
        field_of_view_range()
    )]
    Camera {
        /// Which of the scene's cameras, from 0.
        index: usize,
        /// Its name.
        name: String,
    },
    /// A picture cannot be read.
    #[error("texture {index} cannot be read: {source}")]
    Picture {
        /// Which texture, from 0.
        index: usize,
        /// Why.
        source: ImageError,
    },
    /// A file of a BRDF cannot be used.
    #[error("BRDF {index} cannot be read: {source}")]
    Brdf {
        /// Which file, from 0.
        index: usize,
        /// Why.
        source: BrdfFileError,
    },
    /// A material refers to a BRDF that is not there.
    #[error("material `{material}` refers to BRDF {index}, but there are {count}")]
    NoBrdf {
        /// Name of the material.
        material: String,
        /// The index.
        index: u32,
        /// Number of files.
        count: usize,
    },
    /// The metadata cannot be read.
    #[error("the metadata cannot be read ({0})")]
    Metadata(String),
}

impl Damage {
    /// Of what a part of a bake has stored.
    pub(super) fn of_part(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Part(Box::new(error))
    }
}

/// Errors of a surface point.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SurfelDamage {
    /// Its position.
    #[error("has a position that is no finite number within {MOST_COORDINATE} m of the origin")]
    Position,
    /// Its normal.
    #[error("has a normal that is not of length 1")]
    Normal,
    /// A triangle that is not there.
    #[error("lies on triangle {triangle}, but there are {count}")]
    Triangle {
        /// Its triangle.
        triangle: u32,
        /// Number of triangles.
        count: usize,
    },
    /// Where on the triangle it is.
    #[error("has a place on its triangle that is no finite number from 0 to 1")]
    Place,
}
