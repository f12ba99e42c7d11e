//! A folder that a command fills with files of known names.

use anyhow::{Result, bail};
use lapidary_core::output::{OutputError, check_output, check_writable, folder_of};
use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

/// A folder, and what is written into it.
#[derive(Clone, Debug)]
pub struct FilledFolder {
    path: PathBuf,
    /// Relative to the folder, with `/`.
    names: HashSet<String>,
    /// Names with a `*`.
    patterns: HashSet<String>,
}

impl FilledFolder {
    pub fn new(path: &Path, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        let (patterns, names) = names.into_iter().map(Into::into).partition(|name: &String| name.contains('*'));
        Self { path: path.into(), names, patterns }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks that it is a folder or can be made, and that what is written into it is no input and takes the place of files only.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        if let Some(input) = inputs.iter().find(|input| self.is(input) || self.holds(input)) {
            bail!(
                "the output's folder has an input, which would be written over; choose another folder ({})",
                input.display()
            );
        }
        if self.path.is_dir() {
            check_writable(&self.path)?;
            return self.there().iter().try_for_each(|file| Ok(check_output(file, inputs)?));
        }
        // A link to nowhere is there, too.
        if fs::symlink_metadata(&self.path).is_ok() {
            bail!(
                "something else lies where the output's folder would be; choose another name ({})",
                self.path.display()
            );
        }
        let above =
            self.path.ancestors().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        let there = above.into_iter().find(|folder| fs::symlink_metadata(folder).is_ok());
        check_writable(there.unwrap_or(Path::new("."))).map_err(|error| match error {
            OutputError::NoFolder { folder } => {
                anyhow::anyhow!(
                    "cannot create the folder in what is no folder; choose another name ({})",
                    folder.display()
                )
            }
            error => error.into(),
        })
    }

    /// Checks that nothing is written both here and by one of the `others`.
    pub fn check_apart(&self, others: &[Self]) -> Result<()> {
        let same: Vec<&Self> = others.iter().filter(|other| other.path == self.path || other.is(&self.path)).collect();
        match self.names.iter().find(|name| same.iter().any(|other| other.writes(name))) {
            Some(name) => bail!(
                "two outputs are the same file; choose another name for one of them ({})",
                self.path.join(name).display()
            ),
            None => Ok(()),
        }
    }

    /// Whether a file is one of those that are written into the folder, by its name or by what its name leads to.
    pub fn holds(&self, file: &Path) -> bool {
        let by_name = file.file_name().and_then(|name| Some(canonical(folder_of(file))?.join(name)));
        let Some(folder) = canonical(&self.path) else { return false };
        let mut places = [by_name, canonical(file)].into_iter().flatten();
        places.any(|place| place.strip_prefix(&folder).is_ok_and(|name| self.has_name(name)))
    }

    fn has_name(&self, name: &Path) -> bool {
        let name: Vec<_> = name.iter().map(|part| part.to_string_lossy()).collect();
        self.writes(&name.join("/"))
    }

    fn writes(&self, name: &str) -> bool {
        self.names.contains(name) || self.patterns.iter().any(|pattern| matches(pattern, name))
    }

    /// Whether a path leads to this folder.
    fn is(&self, path: &Path) -> bool {
        path.is_dir() && canonical(path).is_some_and(|path| Some(path) == canonical(&self.path))
    }

    /// What is there of what is written.
    fn there(&self) -> Vec<PathBuf> {
        let names = self.names.iter().chain(&self.patterns);
        let parts: HashSet<&Path> = names.map(|name| folder_of(Path::new(name))).collect();
        let entries = |part: &Path| fs::read_dir(self.path.join(part)).into_iter().flatten().flatten();
        let files = parts.into_iter().flat_map(|part| entries(part).map(move |entry| part.join(entry.file_name())));
        let written = files.filter(|name| self.has_name(name.strip_prefix(".").unwrap_or(name)));
        written.map(|name| self.path.join(name)).collect()
    }
}

fn canonical(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

fn matches(pattern: &str, name: &str) -> bool {
    let rest = |(before, after)| name.strip_prefix(before).is_some_and(|rest: &str| rest.ends_with::<&str>(after));
    pattern.split_once('*').is_some_and(rest)
}
