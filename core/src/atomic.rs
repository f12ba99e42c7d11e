//! Replacing a file only when its successor is complete and on disk.

use std::{
    io::{self, Write},
    path::Path,
};
use tempfile::NamedTempFile;

/// An empty temporary file in the folder of `path`, as readable as any other output.
///
/// # Errors
/// What the file system says.
pub fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lapidary-").suffix(".tmp");
    #[cfg(unix)]
    {
        // Temporary files are private by default.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Flushes a temporary file to disk and gives it its final name. On failure the file that had the name is kept.
///
/// # Errors
/// What the file system says.
pub fn persist(file: NamedTempFile, path: &Path) -> io::Result<()> {
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Writes `bytes` under a temporary name and renames it to `path`.
///
/// # Errors
/// What the file system says; a file that was there before is kept then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = temporary_beside(path)?;
    file.write_all(bytes)?;
    persist(file, path)
}
