//! Requests about materials, and parts that have them.

use lapidary_core::material::Material;
use lapidary_core::parts::Part;
use std::path::PathBuf;

/// A request about materials, and parts that have them.
#[derive(Clone, Debug)]
pub enum MaterialAction {
    /// Use a picture as a map of a material.
    LoadTexture {
        /// Which material.
        material: usize,
        /// Which map.
        map: &'static str,
        /// The picture.
        path: Option<PathBuf>,
    },
    /// Use the BRDF of a file for a material.
    LoadBrdf {
        /// Which material.
        material: usize,
        /// The file.
        path: Option<PathBuf>,
    },
    /// Replace a material by that of a file.
    Load {
        /// Which material.
        material: usize,
        /// The material file.
        path: Option<PathBuf>,
    },
    /// Write a material to a file.
    Save {
        /// Which material.
        material: usize,
        /// The material file.
        path: Option<PathBuf>,
    },
    /// Give a part another material of the document.
    Assign {
        /// Which part.
        part: Part,
        /// Which material.
        material: usize,
    },
    /// Give a part a material of its own.
    MakeUnique {
        /// Which part.
        part: Part,
        /// The material; a copy of what the part has if there is none.
        material: Option<Box<Material>>,
    },
    /// Show a variant of the materials, or what the file shows first.
    ChooseVariant(Option<usize>),
}

impl MaterialAction {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::LoadTexture { path, .. }
            | Self::LoadBrdf { path, .. }
            | Self::Load { path, .. }
            | Self::Save { path, .. } => Some(path),
            _ => None,
        }
    }
}
