//! Common interface of the lists of formats: the file extension determines the format.

use std::path::Path;

/// A format identified by its file extension.
pub trait FileFormat: Sized + 'static {
    /// All formats, in the order of lists.
    const ALL: &'static [Self];

    /// File extensions in lower case, the usual one first.
    fn endings(&self) -> &'static [&'static str];

    /// The format of a file, by its extension in any case.
    fn of(path: &Path) -> Option<&'static Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.iter().find(|format| format.endings().contains(&ending.as_str()))
    }

    /// The extensions of the formats for which `wanted` holds.
    fn all_endings(wanted: impl Fn(&Self) -> bool) -> Vec<&'static str> {
        Self::ALL.iter().filter(|format| wanted(format)).flat_map(Self::endings).copied().collect()
    }
}

/// Extensions for display, such as `.obj, .gltf or .ply`, with the given separator before the last.
pub fn listed(endings: &[&str], before_last: &str) -> String {
    let mut names = endings.iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() { last } else { names.join(", ") + before_last + &last }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{MaterialFormat, PictureFormat, SceneFormat};

    #[test]
    fn endings_tell_the_format_in_any_case() {
        let label = |path: &str| SceneFormat::of(Path::new(path)).map(|format| format.label);
        assert_eq!(
            [label("a.b.GLB"), label("a.obj"), label("a.fbx"), label("ply")],
            [Some("glTF"), Some("OBJ"), None, None]
        );
        assert_eq!(SceneFormat::names(), ".obj, .gltf, .glb or .ply");
        assert_eq!(SceneFormat::names_richest_first(), ".gltf, .glb, .obj, .ply");
        assert_eq!(listed(&["a"], " or "), ".a");
    }

    #[test]
    fn no_ending_is_of_two_formats() {
        fn once<F: FileFormat>() {
            let mut all = F::all_endings(|_| true);
            let count = all.len();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), count);
        }
        once::<SceneFormat>();
        once::<MaterialFormat>();
        once::<PictureFormat>();
    }
}
