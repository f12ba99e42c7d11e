//! Why a dataset cannot be written or read.

use crate::{
    cut::CutError,
    lights::LightProblem,
    meshless::{BasisError, TransportError},
    scene::MeshError,
};
use std::path::PathBuf;
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
    /// The contents contradict themselves.
    #[error("the dataset is damaged: {reason}; copy it again from its source or bake again ({})", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        reason: Damage,
    },
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
    /// The tree order is no permutation of a power of two.
    #[error("the order of the light tree is no permutation of 2^H samples")]
    Tree,
    /// A surface source is invalid.
    #[error(transparent)]
    Source(#[from] SourceDamage),
    /// The meshless basis or its links are invalid.
    #[error(transparent)]
    Meshless(#[from] MeshlessDamage),
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
    #[error("camera {index} (`{name}`) has a place, a direction or a field of view that is no finite number")]
    Camera {
        /// Which of the scene's cameras, from 0.
        index: usize,
        /// Its name.
        name: String,
    },
    /// The metadata cannot be read.
    #[error("the metadata cannot be read ({0})")]
    Metadata(String),
}

/// Errors of surface sources.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum SourceDamage {
    /// No power of two.
    #[error("{0} surface sources make no complete binary tree")]
    Count(usize),
    /// A coordinate or area is no number, or an area is negative.
    #[error("surface source {0} has a place or an area that is no finite number")]
    NotFinite(usize),
    /// A triangle that is not there.
    #[error("surface source {source_index} lies on triangle {triangle}, but there are {count}")]
    Triangle {
        /// Which source.
        source_index: usize,
        /// Its triangle.
        triangle: u32,
        /// Number of triangles.
        count: usize,
    },
}

/// Errors of the meshless basis.
#[derive(Debug, Error, PartialEq)]
pub enum MeshlessDamage {
    /// Its points or levels.
    #[error(transparent)]
    Basis(BasisError),
    /// Its links.
    #[error(transparent)]
    Transport(TransportError),
    /// A place on its triangle that is no number.
    #[error("function {function} of the meshless basis has a place that is no finite number")]
    Place {
        /// Which function.
        function: usize,
    },
    /// A triangle that is not there.
    #[error("function {function} of the meshless basis lies on triangle {triangle}, but there are {count}")]
    Triangle {
        /// Which function.
        function: usize,
        /// Its triangle.
        triangle: u32,
        /// Number of triangles.
        count: usize,
    },
}
