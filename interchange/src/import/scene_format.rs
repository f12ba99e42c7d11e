//! The list of scene formats. A new one needs a file beside this one, and an entry here.

use super::{Files, ImportError, ImportOptions, Source, gltf, obj, ply};
use crate::file_format::{FileFormat, listed};
use lapidary_core::animation::Animation;
use std::path::Path;

/// Possible contents of a scene file.
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
    /// Several scenes.
    Scenes,
    /// Variants of its materials.
    Variants,
    /// Animations.
    Animations,
}

/// Reads a file at a path with its companion files: a scene of it, in a material variant.
type Read = fn(&[u8], &Path, Files, &ImportOptions) -> Result<Source, ImportError>;
/// Reads the animation of a scene of a file.
type ReadAnimation = fn(&[u8], &Path, Files, &ImportOptions) -> Result<Animation, ImportError>;

/// A format of scenes.
pub struct SceneFormat {
    /// Display name.
    pub label: &'static str,
    endings: &'static [&'static str],
    /// Possible contents of its files.
    pub holds: &'static [Content],
    /// Reads a file: a scene of it and a material variant if it has any.
    pub(super) read: Read,
    /// Reads the animation of a file, if the format supports it.
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
                Content::Scenes,
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
    /// All extensions, of the formats with most contents first.
    pub fn richest_first() -> Vec<&'static str> {
        let mut formats: Vec<_> = Self::ALL.iter().collect();
        formats.sort_by_key(|format| std::cmp::Reverse(format.holds.len()));
        formats.into_iter().flat_map(Self::endings).copied().collect()
    }

    /// All extensions as text, such as `.obj, .gltf or .ply`.
    pub fn names() -> String {
        listed(&Self::all_endings(|_| true), " or ")
    }

    /// All extensions as text, of the formats with most contents first.
    pub fn names_richest_first() -> String {
        listed(&Self::richest_first(), ", ")
    }

    /// Whether its files may hold `content`.
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
