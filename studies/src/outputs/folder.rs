//! A folder that a command fills with files of known names.

use anyhow::{Result, bail};
use lapidary_core::output::{OutputError, check_kind, check_protection, check_writable, folder_of, is_same_output};
use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

/// A folder and the names written into it.
#[derive(Clone, Debug)]
pub struct FilledFolder {
    path: PathBuf,
    /// Names relative to the folder, with `/`.
    names: HashSet<String>,
    /// Names with a `*`.
    patterns: HashSet<String>,
    /// Whether existing files are kept.
    keeps: bool,
}

impl FilledFolder {
    pub fn new(path: &Path, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        let (patterns, names) = names.into_iter().map(Into::into).partition(|name: &String| name.contains('*'));
        Self { path: path.into(), names, patterns, keeps: false }
    }

    /// Keeps existing files, so the folder may be read-only.
    pub fn keeping(self) -> Self {
        Self { keeps: true, ..self }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks that it is or can become a folder, and that the written files are not inputs and replace only files.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        if let Some(input) = inputs.iter().find(|input| self.is(input) || self.holds(input)) {
            bail!(
                "the output's folder has an input, which would be written over; choose another folder ({})",
                input.display()
            );
        }
        if self.path.is_dir() {
            check_writable(&self.path)?;
            return self.check_there(inputs);
        }
        // A dangling link exists too.
        if fs::symlink_metadata(&self.path).is_ok() {
            bail!(
                "the output must be a folder, but something that is no folder has its name; choose another name ({})",
                self.path.display()
            );
        }
        let above =
            self.path.ancestors().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        let there = above.into_iter().find(|folder| fs::symlink_metadata(folder).is_ok());
        check_writable(there.unwrap_or(Path::new("."))).map_err(|error| match error {
            OutputError::NoFolder { folder } => {
                anyhow::anyhow!(
                    "the output's folder would lie in something that is no folder; choose another name ({})",
                    folder.display()
                )
            }
            error => error.into(),
        })
    }

    /// Checks existing files that would be written. The folder itself is checked before, once for all files.
    fn check_there(&self, inputs: &[&Path]) -> Result<()> {
        let inputs: Vec<&Path> = inputs.iter().copied().filter(|input| input.is_file()).collect();
        for file in self.there() {
            check_kind(&file)?;
            // An input under another name or folder may be the same file.
            if inputs.iter().any(|input| is_same_output(&file, input)) {
                return Err(OutputError::Input { path: file }.into());
            }
            if !self.keeps {
                check_protection(&file)?;
            }
        }
        Ok(())
    }

    /// Checks that no file is written both here and by one of the `others`.
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

    /// Whether a file is among those written into the folder, by name or through links.
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

    /// Existing files that would be written.
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
    let Some((before, after)) = pattern.split_once('*') else { return false };
    let text = name.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
    text.is_some_and(|text| !text.contains('/'))
}
