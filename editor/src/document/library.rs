//! The library of environments: the bundled maps and those that the user added.

use super::{
    path_list::{PathList, same_file},
    relative::absolute,
};
use anyhow::Result;
use lapidary_interchange::formats::PictureFormat;
use std::path::{Path, PathBuf};

/// Environment maps to choose from; the user's are kept in the configuration folder.
#[derive(Clone, Debug)]
pub struct EnvironmentLibrary {
    bundled: Vec<LibraryEntry>,
    list: PathList,
}

/// A map of the library.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LibraryEntry {
    /// Absolute.
    pub path: PathBuf,
    /// The file's name without extension.
    pub name: String,
    /// Whether it is bundled, and cannot be removed.
    pub bundled: bool,
    /// Whether its file was missing when the library was read.
    pub missing: bool,
}

impl EnvironmentLibrary {
    /// Reads the user's list; a damaged one is empty. `bundled` holds the bundled maps, as [`maps_in`] finds them.
    pub fn open(config: &Path, bundled: impl IntoIterator<Item = PathBuf>) -> Self {
        let bundled = bundled.into_iter().map(|path| entry(absolute(&path), true, !path.exists())).collect();
        Self { bundled, list: PathList::open(config.join("environments.json")) }
    }

    /// The bundled maps, then the user's in the order of adding.
    pub fn entries(&self) -> Vec<LibraryEntry> {
        let own = self.list.entries().iter().map(|file| entry(file.path.clone(), false, file.missing));
        self.bundled.iter().cloned().chain(own).collect()
    }

    /// Adds maps that are not in the library yet; for a folder, all maps in it. Returns the number of new ones.
    ///
    /// # Errors
    /// A list that cannot be written; the maps are in it until the program ends.
    pub fn add(&mut self, paths: &[PathBuf]) -> Result<usize> {
        let maps = paths.iter().flat_map(|path| if path.is_dir() { maps_in(path) } else { vec![path.clone()] });
        let bundled = &self.bundled;
        let mut added = 0;
        let change = |list: &mut Vec<PathBuf>| {
            for map in maps {
                let known = bundled.iter().map(|entry| &entry.path).chain(list.iter()).any(|p| same_file(p, &map));
                if !known {
                    list.push(absolute(&map));
                    added += 1;
                }
            }
        };
        self.list.change(change)?;
        Ok(added)
    }

    /// Takes a map out of the user's list; its file stays.
    ///
    /// # Errors
    /// A list that cannot be written.
    pub fn remove(&mut self, path: &Path) -> Result<()> {
        self.list.change(|list| list.retain(|other| !same_file(other, path)))
    }
}

fn entry(path: PathBuf, bundled: bool, missing: bool) -> LibraryEntry {
    let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    LibraryEntry { path, name, bundled, missing }
}

/// The .hdr and .exr files in a folder, by name.
pub fn maps_in(folder: &Path) -> Vec<PathBuf> {
    let is_map = |path: &PathBuf| PictureFormat::is_of_light(path) && path.is_file();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut maps: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_map).collect();
    maps.sort();
    maps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_added_once_kept_flagged_and_removed() {
        let folder = tempfile::tempdir().unwrap();
        let (data, own) = (folder.path().join("data"), folder.path().join("own"));
        for path in ["data/studio.hdr", "own/b.EXR", "own/a.hdr", "own/readme.txt"] {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, b"").unwrap();
        }
        let config = folder.path().join("config");
        let open = || EnvironmentLibrary::open(&config, maps_in(&data));
        let mut library = open();
        assert_eq!(library.add(&[own.clone(), own.join("a.hdr"), data.join("studio.hdr")]).unwrap(), 2);
        assert_eq!(library.add(&[own.join("../own/a.hdr")]).unwrap(), 0);
        std::fs::remove_file(own.join("a.hdr")).unwrap();
        let listed: Vec<_> = open().entries().into_iter().map(|e| (e.name, e.bundled, e.missing)).collect();
        let expected = [("studio", true, false), ("a", false, true), ("b", false, false)];
        assert_eq!(listed, expected.map(|(name, bundled, missing)| (name.to_owned(), bundled, missing)));
        library.remove(&own.join("a.hdr")).unwrap();
        library.remove(&data.join("studio.hdr")).unwrap();
        let names: Vec<_> = open().entries().into_iter().map(|e| e.name).collect();
        assert_eq!(names, ["studio", "b"], "bundled maps stay");
    }

    #[test]
    fn a_damaged_list_leaves_the_bundled_maps() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("environments.json"), "[\"a").unwrap();
        let library = EnvironmentLibrary::open(folder.path(), [folder.path().join("gone.hdr")]);
        assert_eq!(library.entries().len(), 1);
        assert!(library.entries()[0].missing);
        assert!(maps_in(Path::new("/nowhere")).is_empty());
    }
}
