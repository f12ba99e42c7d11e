//! A list of paths in its own JSON file, which may be damaged and which other windows change too.

use super::relative::absolute;
use anyhow::{Context, Result};
use lapidary_core::{input, output::write_atomically};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A file of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedFile {
    /// Absolute.
    pub path: PathBuf,
    /// Whether it was missing when the list was read: deleted, or on a detached drive.
    pub missing: bool,
}

/// A list of paths and the file that keeps it.
#[derive(Clone, Debug)]
pub struct PathList {
    file: PathBuf,
    entries: Vec<ListedFile>,
}

impl PathList {
    /// Reads the list; leaves out unreadable entries.
    pub fn open(file: PathBuf) -> Self {
        let entries = entries(read(&file));
        Self { file, entries }
    }

    /// The paths in their order.
    pub fn entries(&self) -> &[ListedFile] {
        &self.entries
    }

    /// Reads the list as other windows left it, changes and writes it.
    ///
    /// # Errors
    /// Errors of the file system; the list is changed in memory then.
    pub fn change(&mut self, change: impl FnOnce(&mut Vec<PathBuf>)) -> Result<()> {
        let mut paths = if self.file.exists() { read(&self.file) } else { self.paths() };
        change(&mut paths);
        let written = write(&self.file, &paths);
        self.entries = entries(paths);
        written
    }

    fn paths(&self) -> Vec<PathBuf> {
        self.entries.iter().map(|entry| entry.path.clone()).collect()
    }
}

fn entries(paths: Vec<PathBuf>) -> Vec<ListedFile> {
    paths.into_iter().map(|path| ListedFile { missing: !path.exists(), path }).collect()
}

fn read(file: &Path) -> Vec<PathBuf> {
    let parsed = input::read_text(file).ok().and_then(|text| serde_json::from_str(&text).ok());
    let Some(Value::Array(list)) = parsed else { return Vec::new() };
    list.iter().filter_map(Value::as_str).filter(|path| !path.is_empty()).map(PathBuf::from).collect()
}

fn write(file: &Path, paths: &[PathBuf]) -> Result<()> {
    let list = Value::from_iter(paths.iter().map(|path| path.to_string_lossy()));
    write_setting(file, &format!("{list:#}\n"))
}

/// Writes a file of the configuration folder, creating the folder if needed.
///
/// # Errors
/// Errors of the file system, with the remedy.
pub fn write_setting(file: &Path, text: &str) -> Result<()> {
    let made = file.parent().map_or(Ok(()), std::fs::create_dir_all);
    made.and_then(|()| write_atomically(file, text.as_bytes())).with_context(|| {
        format!(
            "cannot keep this for the next start; check the permissions, or set LAPIDARY_HOME to another folder ({})",
            file.display()
        )
    })
}

/// Whether both are the same file, also through links. Missing files are compared by path.
pub fn same_file(a: &Path, b: &Path) -> bool {
    let canonical = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| absolute(path));
    canonical(a) == canonical(b)
}
