//! Recent files for the File menu.

use super::{
    path_list::{PathList, same_file},
    relative::absolute,
};
use anyhow::Result;
use std::path::Path;

pub use super::path_list::ListedFile;

/// Most files in the menu.
const COUNT: usize = 12;

/// The list, kept in the configuration folder.
#[derive(Clone, Debug)]
pub struct RecentFiles(PathList);

impl RecentFiles {
    /// Reads the list; a damaged one is empty.
    pub fn open(config: &Path) -> Self {
        Self(PathList::open(config.join("recent.json")))
    }

    /// The newest first; missing files are kept, since their drive may come back.
    pub fn entries(&self) -> &[ListedFile] {
        let entries = self.0.entries();
        &entries[..entries.len().min(COUNT)]
    }

    /// Puts a file that was opened or saved at the front.
    ///
    /// # Errors
    /// A list that cannot be written; the file is in it until the program ends.
    pub fn add(&mut self, path: &Path) -> Result<()> {
        self.0.change(|paths| {
            paths.retain(|other| !same_file(other, path));
            paths.insert(0, absolute(path));
            paths.truncate(COUNT);
        })
    }

    /// Takes a file out.
    ///
    /// # Errors
    /// A list that cannot be written.
    pub fn remove(&mut self, path: &Path) -> Result<()> {
        self.0.change(|paths| paths.retain(|other| !same_file(other, path)))
    }

    /// Forgets all.
    ///
    /// # Errors
    /// A list that cannot be written.
    pub fn clear(&mut self) -> Result<()> {
        self.0.change(Vec::clear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(recent: &RecentFiles) -> Vec<String> {
        recent.entries().iter().map(|e| e.path.file_name().unwrap().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn the_newest_is_first_and_none_is_twice() {
        let folder = tempfile::tempdir().unwrap();
        let (config, files) = (folder.path().join("config"), folder.path().join("files"));
        std::fs::create_dir(&files).unwrap();
        let mut recent = RecentFiles::open(&config);
        for i in 0..15 {
            recent.add(&files.join(format!("{i}.cuts"))).unwrap();
        }
        std::fs::write(files.join("9.cuts"), b"").unwrap();
        recent.add(&files.join("../files/9.cuts")).unwrap();
        let kept = RecentFiles::open(&config);
        assert_eq!(names(&kept), names(&recent));
        assert_eq!(names(&kept)[..3], ["9.cuts", "14.cuts", "13.cuts"]);
        assert_eq!(kept.entries().len(), COUNT);
        assert_eq!(kept.entries().iter().filter(|e| !e.missing).count(), 1);
        recent.remove(&files.join("14.cuts")).unwrap();
        assert_eq!(names(&recent)[..2], ["9.cuts", "13.cuts"]);
        recent.clear().unwrap();
        assert!(RecentFiles::open(&config).entries().is_empty());
    }

    #[test]
    fn two_windows_keep_each_others_files() {
        let folder = tempfile::tempdir().unwrap();
        let (mut a, mut b) = (RecentFiles::open(folder.path()), RecentFiles::open(folder.path()));
        a.add(Path::new("/a.cuts")).unwrap();
        b.add(Path::new("/b.cuts")).unwrap();
        assert_eq!(names(&b), ["b.cuts", "a.cuts"]);
    }

    #[test]
    fn a_damaged_list_is_empty_and_what_is_no_path_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("recent.json");
        for (text, count) in [("[\"/a", 0), ("{}", 0), ("[1, \"/a.cuts\", null, \"\"]", 1)] {
            std::fs::write(&file, text).unwrap();
            assert_eq!(RecentFiles::open(folder.path()).entries().len(), count, "{text}");
        }
    }

    #[test]
    fn a_list_that_cannot_be_written_works_until_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("config");
        std::fs::write(&config, b"a file where the folder should be").unwrap();
        let mut recent = RecentFiles::open(&config);
        for name in ["/a.cuts", "/b.cuts"] {
            assert!(recent.add(Path::new(name)).unwrap_err().to_string().contains("LAPIDARY_HOME"));
        }
        assert_eq!(names(&recent), ["b.cuts", "a.cuts"]);
    }
}
