//! Writes files: overwriting is checked before the work, and a file is replaced only when its successor is complete and
//! on disk. All output goes through this module.

#[cfg(feature = "test-faults")]
mod faults;

use crate::input::what_it_is;
use same_file::is_same_file;
use std::{
    fs::{self, Metadata, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
};
use thiserror::Error;

/// Why a path cannot be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The output would overwrite an input.
    #[error("the output would be written over an input; choose another name ({})", path.display())]
    Input {
        /// The output.
        path: PathBuf,
    },
    /// The path is a folder.
    #[error("the output's name is that of a folder; add the name of a file ({})", path.display())]
    NoName {
        /// The output.
        path: PathBuf,
    },
    /// The path is something that is never replaced.
    #[error("{source} ({})", path.display())]
    NotAFile {
        /// The output.
        path: PathBuf,
        /// Its kind.
        source: io::Error,
    },
    /// The existing file is protected.
    #[error("the output is there and read-only; make it writable, or choose another name ({})", path.display())]
    ReadOnly {
        /// The output.
        path: PathBuf,
    },
    /// The folder is missing.
    #[error("there is no folder to write to; create it first ({})", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder is not writable.
    #[error("cannot write to the folder; check its permissions and the free space ({})", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The error of the file system.
        source: io::Error,
    },
}

/// Writes `bytes` under a temporary name in the folder of `path` and renames it once it is on disk.
///
/// # Errors
/// Errors of the file system, or anything but a file at `path`, which is then kept.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_parts_atomically(path, [bytes])
}

/// [`write_atomically`] for a file in parts, which need not be contiguous in memory.
///
/// # Errors
/// See [`write_atomically`].
pub fn write_parts_atomically<'a>(path: &Path, parts: impl IntoIterator<Item = &'a [u8]>) -> io::Result<()> {
    file_to_replace(path)?;
    let mut file = temporary_in(folder_of(path))?;
    #[cfg(feature = "test-faults")]
    let fault = faults::next();
    let parts: Vec<&[u8]> = parts.into_iter().collect();
    if let Some((last, first)) = parts.split_last() {
        first.iter().try_for_each(|bytes| file.write_all(bytes))?;
        #[cfg(feature = "test-faults")]
        fault.write(&mut file, last)?;
        file.write_all(last)?;
    }
    file.as_file().sync_all()?;
    #[cfg(feature = "test-faults")]
    fault.rename()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Checks that `path` can be written without loss, before the work for it starts.
///
/// # Errors
/// An output that is one of the `inputs`, by any name; a folder, a link, a device; a read-only file; a folder that is
/// missing or not writable.
pub fn check_output(path: &Path, inputs: &[&Path]) -> Result<(), OutputError> {
    let ends_as_folder = |bytes: &[u8]| bytes.last().is_some_and(|&b| std::path::is_separator(b.into()));
    if path.file_name().is_none() || ends_as_folder(path.as_os_str().as_encoded_bytes()) {
        return Err(OutputError::NoName { path: path.into() });
    }
    check_kind(path)?;
    if inputs.iter().any(|input| is_same_output(path, input)) {
        return Err(OutputError::Input { path: path.into() });
    }
    check_protection(path)?;
    check_writable(folder_of(path))
}

/// Checks that `path` is a file or free.
///
/// # Errors
/// A folder, a link or a device.
pub fn check_kind(path: &Path) -> Result<(), OutputError> {
    file_to_replace(path).map(drop).map_err(|source| OutputError::NotAFile { path: path.into(), source })
}

/// Checks that an existing file at `path` may be overwritten.
///
/// # Errors
/// A read-only file.
pub fn check_protection(path: &Path) -> Result<(), OutputError> {
    let is_protected = |there: Metadata| there.permissions().readonly() || !takes_bytes(path);
    if fs::metadata(path).is_ok_and(is_protected) {
        return Err(OutputError::ReadOnly { path: path.into() });
    }
    Ok(())
}

/// Checks that a folder exists and is writable, before the work for it starts.
///
/// # Errors
/// A folder that is missing or not writable.
pub fn check_writable(folder: &Path) -> Result<(), OutputError> {
    if !folder.is_dir() {
        return Err(OutputError::NoFolder { folder: folder.into() });
    }
    temporary_in(folder).map(drop).map_err(|source| OutputError::Folder { folder: folder.into(), source })
}

/// Whether writing to `path` is writing to `other`: the same file by any name, or the same free place.
pub fn is_same_output(path: &Path, other: &Path) -> bool {
    // Only files are opened: a pipe would wait for its other end.
    if path.is_file() && other.is_file() {
        return is_same_file(path, other).unwrap_or(false);
    }
    let place = |path: &Path| Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?));
    place(path).is_some_and(|place_of_path| place(other) == Some(place_of_path))
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The file at `path`, if it exists.
///
/// # Errors
/// Something else at `path`: it would be lost, and a file in its place would not be expected there.
fn file_to_replace(path: &Path) -> io::Result<Option<Metadata>> {
    let there = match fs::symlink_metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        there => there?,
    };
    if there.is_file() {
        return Ok(Some(there));
    }
    let kind = if there.is_dir() { io::ErrorKind::IsADirectory } else { io::ErrorKind::InvalidInput };
    let what = if there.is_symlink() { "a symbolic link" } else { what_it_is(there.file_type()) };
    Err(io::Error::new(kind, format!("the output is {what}, and only files are written over; choose another name")))
}

/// Whether an existing file can be opened for writing; writes nothing.
fn takes_bytes(path: &Path) -> bool {
    OpenOptions::new().write(true).open(path).is_ok()
}

/// A file that is removed unless it is renamed; its name is random and unused.
fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lapidary-").suffix(".tmp");
    #[cfg(unix)]
    {
        // Temporary files are private by default; the finished file is as readable as any other output.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests;
