//! The list of all formats of scenes. A new one is a file beside this one, and its entry here.

use super::{Files, ImportError, Source, gltf, obj, ply};
use crate::file_format::{FileFormat, listed};
use lapidary_core::animation::Animation;
use std::path::Path;

/// What a file of a scene may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Triangles.
    Meshes,
    /// Materials with maps.
    Materials,
    /// Cameras.
    Cameras,
    /// Local lights.
    Lights,
    /// Variants of its materials.
    Variants,
    /// What moves.
    Animations,
}

/// Reads a file at a path with its files beside it, in a variant of its materials.
type Read = fn(&[u8], &Path, Files, Option<&str>) -> Result<Source, ImportError>;
/// Reads what moves.
type ReadAnimation = fn(&[u8], &Path, Files) -> Result<Animation, ImportError>;

/// A format of scenes.
pub struct SceneFormat {
    /// Name for people.
    pub label: &'static str,
    endings: &'static [&'static str],
    /// What its files may hold.
    pub holds: &'static [Content],
    /// Reads a file, with a variant of its materials if it may hold any.
    pub(super) read: Read,
    /// Reads what moves in a file, if it may hold that.
    pub(super) animation: Option<ReadAnimation>,
}

impl FileFormat for SceneFormat {
    const ALL: &'static [Self] = &[
        Self {
            label: "OBJ",
            endings: &["obj"],
            holds: &[Content::Meshes, Content::Materials],
            read: |bytes, path, files, _| obj::read(bytes, path, files),
            animation: None,
        },
        Self {
            label: "glTF",
            endings: &["gltf", "glb"],
            holds: &[
                Content::Meshes,
                Content::Materials,
                Content::Cameras,
                Content::Lights,
                Content::Variants,
                Content::Animations,
            ],
            read: gltf::read,
            animation: Some(gltf::read_animation),
        },
        Self {
            label: "PLY",
            endings: &["ply"],
            holds: &[Content::Meshes],
            read: |bytes, path, files, _| ply::read(bytes, path, files),
            animation: None,
        },
    ];

    fn endings(&self) -> &'static [&'static str] {
        self.endings
    }
}

impl SceneFormat {
    /// All endings, those of the formats that hold most first.
    pub fn richest_first() -> Vec<&'static str> {
        let mut formats: Vec<_> = Self::ALL.iter().collect();
        formats.sort_by_key(|format| std::cmp::Reverse(format.holds.len()));
        formats.into_iter().flat_map(Self::endings).copied().collect()
    }

    /// All endings as text, as `.obj, .gltf or .ply`.
    pub fn names() -> String {
        listed(&Self::all_endings(|_| true), " or ")
    }

    /// All endings as text, those of the formats that hold most first.
    pub fn names_richest_first() -> String {
        listed(&Self::richest_first(), ", ")
    }

    /// Whether its files may hold something.
    pub fn holds(&self, content: Content) -> bool {
        self.holds.contains(&content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_can_be_read() {
        assert!(SceneFormat::ALL.iter().all(|f| f.holds(Content::Animations) == f.animation.is_some()));
    }
}
