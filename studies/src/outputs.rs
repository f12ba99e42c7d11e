//! What work reads and writes, checked before it begins: nothing is written over an input, and an output that cannot be
//! written is told at once.

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
    /// With files that are read. Those that are not there do no harm.
    #[must_use]
    pub fn reads(mut self, paths: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.inputs.extend(paths.into_iter().map(Into::into));
        self
    }

    /// With files that are written.
    #[must_use]
    pub fn writes(mut self, paths: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.outputs.extend(paths.into_iter().map(Into::into));
        self
    }

    /// With a folder that is made if it is missing, and the names of what is written into it. A name may have one `*`,
    /// which stands for any text without a `/`.
    #[must_use]
    pub fn fills(mut self, folder: &Path, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.folders.push(FilledFolder::new(folder, names));
        self
    }

    /// With a folder as for [`Self::fills`], in which what is there stays.
    #[must_use]
    pub fn completes(mut self, folder: &Path, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.folders.push(FilledFolder::new(folder, names).keeping());
        self
    }

    /// Checks all outputs. It makes nothing.
    ///
    /// # Errors
    /// An output that is an input or another output; that is a folder, a link, a device or read-only; or whose folder
    /// takes no files.
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

    /// All paths that are written or filled.
    pub fn outputs(&self) -> impl Iterator<Item = &Path> {
        self.outputs.iter().map(PathBuf::as_path).chain(self.folders.iter().map(FilledFolder::path))
    }

    /// All paths that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.inputs.iter().map(PathBuf::as_path)
    }
}

/// Creates a folder and those above it, and makes sure that files can be written to it: long work follows.
///
/// # Errors
/// What the file system says.
pub fn create_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).with_context(|| {
        format!("cannot write to the folder; check the path, its permissions and the space ({})", path.display())
    })?;
    Ok(check_writable(path)?)
}

/// Name of the lock of a folder, without its extension.
const FOLDER_LOCK: &str = ".lapidary";

/// Creates a folder that is filled, and takes it until the lock is dropped: what two processes write there would mix.
///
/// # Errors
/// A folder that cannot be written to, or that another process fills.
pub fn take_folder(path: &Path) -> Result<OutputLock> {
    create_folder(path)?;
    Ok(OutputLock::acquire(&path.join(FOLDER_LOCK)).map_err(|error| match error {
        LockError::Held { holder, .. } => LockError::Held { path: path.into(), holder },
        error => error,
    })?)
}

#[cfg(test)]
mod tests;
