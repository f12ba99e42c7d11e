//! Paths of pictures that name a layer. An OpenEXR file may hold several layers, and `FILE.exr#LAYER` is one of them.

use super::open_exr;
use lapidary_core::input;
use std::{
    io::BufReader,
    path::{Path, PathBuf},
};

/// What ends the file and begins the layer.
const EXR: &str = ".exr#";

/// Splits a picture's path into its file and the name of a layer, unless a file has the whole name.
pub fn file_and_layer(path: &Path) -> (&Path, Option<&str>) {
    match path.to_str().and_then(split).filter(|_| !path.is_file()) {
        Some((file, layer)) => (Path::new(file), Some(layer)),
        None => (path, None),
    }
}

/// The path of a layer in a file.
pub fn with_layer(file: &Path, layer: &str) -> PathBuf {
    let mut path = file.as_os_str().to_owned();
    path.push("#");
    path.push(layer);
    path.into()
}

/// The names of the layers of a picture that [`file_and_layer`] accepts, the one that is shown by default first. A file of
/// one layer or another format has none, as has an unreadable one.
pub fn layers_in(path: &Path) -> Vec<String> {
    let (file, _) = file_and_layer(path);
    let names = input::open(file).ok().and_then(|opened| open_exr::names(BufReader::new(opened), file).ok());
    names.filter(|names| names.len() > 1).unwrap_or_default()
}

/// The whole name of the layer that a path names, as [`layers_in`] has it; `None` where it names none, or no such one.
pub fn layer_of(path: &Path) -> Option<String> {
    let (file, layer) = file_and_layer(path);
    open_exr::name(BufReader::new(input::open(file).ok()?), file, layer?).ok()
}

/// Splits a name whether or not there is such a file.
pub(crate) fn split(name: &str) -> Option<(&str, &str)> {
    let end = name.to_ascii_lowercase().rfind(EXR)? + EXR.len();
    Some((&name[..end - 1], &name[end..]))
}

/// The last part of a file's path, with its layer.
pub(crate) fn name_of(file: &Path, layer: Option<&str>) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    layer.map_or_else(|| name.clone().into_owned(), |layer| format!("{name}#{layer}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_split_behind_the_extension_unless_a_file_has_the_whole_name() {
        let split = |path| file_and_layer(Path::new(path));
        assert_eq!(split("a#b/c.EXR#View.Depth/Z#1"), (Path::new("a#b/c.EXR"), Some("View.Depth/Z#1")));
        assert_eq!(split("c.exr#"), (Path::new("c.exr"), Some("")));
        for whole in ["c.exr", "c.png#x", "cexr#x", "", "#"] {
            assert_eq!(split(whole), (Path::new(whole), None));
        }
        assert_eq!(with_layer(Path::new("a/c.exr"), "x"), Path::new("a/c.exr#x"));
        assert_eq!(name_of(Path::new("a/c.exr"), Some("x/y")), "c.exr#x/y");
        assert_eq!(name_of(Path::new("a/c.exr#x"), None), "c.exr#x");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr#1");
        assert_eq!(file_and_layer(&path).1, Some("1"), "negative control");
        std::fs::write(&path, b"").unwrap();
        assert_eq!(file_and_layer(&path), (&*path, None));
    }
}
