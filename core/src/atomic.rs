//! Replacing a file only when its successor is complete and on disk.

use std::{
    io::{self, Write},
    path::Path,
};

/// Writes `bytes` under a temporary name in the folder of `path` and renames it once it is on disk.
///
/// # Errors
/// Errors of the file system; an existing file is kept then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = temporary_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Checks that files can be made in a folder, before work whose result is to be written there.
///
/// # Errors
/// Errors of the file system.
pub fn check_writable(folder: &Path) -> io::Result<()> {
    temporary_in(folder).map(drop)
}

/// A file that is removed unless it is renamed.
fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lapidary-").suffix(".tmp");
    #[cfg(unix)]
    {
        // Temporary files are private by default; the finished one is as readable as any other output.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_writable_if_files_can_be_made_in_it_and_none_stays() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(folder.path()).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let missing = check_writable(&folder.path().join("missing")).unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
        #[cfg(target_os = "linux")]
        assert!(check_writable(Path::new("/proc")).is_err(), "it is there and takes no files, whoever asks");
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("old");
        write_atomically(&target, b"old").unwrap();
        let below = write_atomically(&target.join("below-a-file"), b"new").unwrap_err();
        assert_eq!(below.kind(), io::ErrorKind::NotADirectory);
        // A folder cannot be replaced by a file: the rename, the last step, is what fails here.
        std::fs::create_dir(folder.path().join("folder")).unwrap();
        let replaced = write_atomically(&folder.path().join("folder"), b"new").unwrap_err();
        assert_eq!(replaced.kind(), io::ErrorKind::IsADirectory);
        assert_eq!(std::fs::read(&target).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
        write_atomically(&target, b"new").unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"new");
    }
}
