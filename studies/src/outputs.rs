//! Inputs and outputs, checked before the work: no input is overwritten, and an unwritable output is reported at once.

mod folder;

use anyhow::{Context, Result, bail};
use folder::FilledFolder;
use lapidary_core::{
    lock::{LockError, OutputLock},
    output::{check_output, check_writable, is_same_output},
};
use std::path::{Path, PathBuf};

/// The files and folders of a command.
#[derive(Clone, Debug, Default)]
pub struct CommandFiles {
    inputs: Vec<PathBuf>,
    outputs: Vec<PathBuf>,
    folders: Vec<FilledFolder>,
}

impl CommandFiles {
    /// Adds files to read. Missing ones are ignored.
    #[must_use]
    pub fn reads(mut self, paths: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.inputs.extend(paths.into_iter().map(Into::into));
        self
    }

    /// Adds files to write.
    #[must_use]
    pub fn writes(mut self, paths: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.outputs.extend(paths.into_iter().map(Into::into));
        self
    }

    /// Adds a folder, created if missing, and the names written into it. A name may have one `*`, which stands for any text without
    /// a `/`.
    #[must_use]
    pub fn fills(mut self, folder: &Path, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.folders.push(FilledFolder::new(folder, names));
        self
    }

    /// Adds a folder as [`Self::fills`], but keeps existing files.
    #[must_use]
    pub fn completes(mut self, folder: &Path, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.folders.push(FilledFolder::new(folder, names).keeping());
        self
    }

    /// Checks all outputs without creating any.
    ///
    /// # Errors
    /// An output that is an input or another output; that is a folder, a link, a device or read-only; or whose folder is not
    /// writable.
    pub fn check(&self) -> Result<()> {
        let inputs: Vec<&Path> = self.inputs.iter().map(PathBuf::as_path).collect();
        for (number, path) in self.outputs.iter().enumerate() {
            let others = &self.outputs[..number];
            if others.iter().any(|other| is_same_output(path, other)) || self.folders.iter().any(|f| f.holds(path)) {
                bail!("two outputs are the same file; choose another name for one of them ({})", path.display());
            }
            check_output(path, &inputs)?;
        }
        for (number, folder) in self.folders.iter().enumerate() {
            folder.check(&inputs)?;
            folder.check_apart(&self.folders[..number])?;
        }
        Ok(())
    }

    /// All output paths.
    pub fn outputs(&self) -> impl Iterator<Item = &Path> {
        self.outputs.iter().map(PathBuf::as_path).chain(self.folders.iter().map(FilledFolder::path))
    }

    /// All input paths.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.inputs.iter().map(PathBuf::as_path)
    }
}

/// Creates a folder and its parents and checks that files can be written there, before long work.
///
/// # Errors
/// The file system's error.
pub fn create_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).with_context(|| {
        format!("cannot write to the folder; check the path, its permissions and the space ({})", path.display())
    })?;
    Ok(check_writable(path)?)
}

/// Name of a folder's lock, without its extension.
const FOLDER_LOCK: &str = ".lapidary";

/// Creates an output folder and locks it until the lock is dropped: files of two processes would mix.
///
/// # Errors
/// An unwritable folder, or one that another process fills.
pub fn take_folder(path: &Path) -> Result<OutputLock> {
    create_folder(path)?;
    Ok(OutputLock::acquire(&path.join(FOLDER_LOCK)).map_err(|error| match error {
        LockError::Held { holder, .. } => LockError::Held { path: path.into(), holder },
        error => error,
    })?)
}

#[cfg(test)]
mod tests;
