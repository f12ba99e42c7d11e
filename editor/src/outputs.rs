//! Pictures to write: checked before the work, written after it.

use anyhow::{Context, Result, bail};
use lapidary_core::image::{Image, ImageError};
use std::path::{Path, PathBuf};

/// Checks that each path names a picture format and lies in a folder that is there.
///
/// # Errors
/// The first path that cannot be written to.
pub fn check_pictures(paths: &[PathBuf]) -> Result<()> {
    for path in paths {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        if !["exr", "hdr", "png"].contains(&extension.as_str()) {
            return Err(ImageError::UnknownExtension { path: path.clone() }.into());
        }
        check_folder(path)?;
    }
    Ok(())
}

/// Checks that the folder of `path` is there.
///
/// # Errors
/// A folder that is not.
pub fn check_folder(path: &Path) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        bail!("there is no folder to write to; create it first ({})", folder.display());
    }
    Ok(())
}

/// Writes one picture to all paths, with its coverage as alpha channel if there is one.
///
/// # Errors
/// The first path that cannot be written to; a file that was there before is kept then.
pub fn write_pictures(image: &Image, coverage: Option<&[f32]>, paths: &[PathBuf]) -> Result<()> {
    for path in paths {
        image.write_with(coverage, path)?;
    }
    Ok(())
}

/// Creates a folder and those above it, and checks that it can be written to.
///
/// # Errors
/// What the file system says.
pub fn create_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).with_context(|| {
        format!("cannot create the folder; check the path and the permissions ({})", path.display())
    })?;
    let probe = path.join(format!(".lapidary-{}", std::process::id()));
    std::fs::write(&probe, [])
        .and_then(|()| std::fs::remove_file(&probe))
        .with_context(|| format!("cannot write to the folder; check its permissions ({})", path.display()))
}
