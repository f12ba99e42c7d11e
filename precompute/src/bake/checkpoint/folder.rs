//! The files in a checkpoint's folder, and foreign files.

use super::{Series, io_error, manifest, share};
use crate::errors::CheckpointError;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Whether the folder exists. A symbolic link does not count: it may lead anywhere.
///
/// # Errors
/// Another file in its place.
pub fn is_there(folder: &Path) -> Result<bool, CheckpointError> {
    match fs::symlink_metadata(folder) {
        Ok(found) if found.is_dir() => Ok(true),
        Ok(_) => Err(CheckpointError::Foreign { path: folder.into() }),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(e) => Err(io_error("read", folder, e)),
    }
}

/// The files in a checkpoint's folder.
pub struct Contents {
    /// Files of bakes and file managers.
    pub ours: Vec<PathBuf>,
    /// The first foreign file.
    pub foreign: Option<PathBuf>,
}

impl Contents {
    /// Lists a folder.
    pub fn of(folder: &Path) -> Result<Self, CheckpointError> {
        let failed = |e| io_error("read", folder, e);
        let (mut ours, mut foreign) = (Vec::new(), None);
        for entry in fs::read_dir(folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let is_file = entry.file_type().map_err(failed)?.is_file();
            match is_file && is_name_of_ours(&entry.file_name().to_string_lossy()) {
                true => ours.push(entry.path()),
                false => foreign = foreign.or(Some(entry.path())),
            }
        }
        Ok(Self { ours, foreign })
    }

    /// The files, if none is foreign.
    ///
    /// # Errors
    /// The first foreign file.
    pub fn all_ours(self) -> Result<Vec<PathBuf>, CheckpointError> {
        self.foreign.map_or(Ok(self.ours), |path| Err(CheckpointError::Foreign { path }))
    }
}

/// Removes files.
pub fn remove(files: &[PathBuf]) -> Result<(), CheckpointError> {
    files.iter().try_for_each(|file| fs::remove_file(file).map_err(|e| io_error("remove", file, e)))
}

fn is_name_of_ours(name: &str) -> bool {
    let is_chunk = |series: Series| {
        let number = name.strip_prefix(series.prefix()).and_then(|rest| rest.strip_suffix(".bin"));
        number.is_some_and(|n| n.len() >= 5 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    // Temporary files of a killed bake, and files of earlier versions.
    let is_temporary = name.starts_with(".lapidary-") && name.ends_with(".tmp");
    let is_earlier = ["places-sources.txt", "places-transport.txt"].contains(&name);
    let is_of_file_manager = [".DS_Store", "desktop.ini", "Thumbs.db"].contains(&name);
    let is_of_share = [share::SHARD, share::SCENE].contains(&name);
    name == manifest::FILE
        || is_of_share
        || is_temporary
        || is_earlier
        || is_of_file_manager
        || Series::ALL.into_iter().any(is_chunk)
}
