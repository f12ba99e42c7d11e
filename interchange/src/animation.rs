//! Animations of scene files.

use crate::{
    file_format::{self, FileFormat},
    import::{self, Content, ImportError, ImportOptions, SceneFormat},
    names::listed,
};
use lapidary_core::animation::{Animation, AnimationError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why an animation cannot be read.
#[derive(Debug, Error)]
pub enum AnimationFileError {
    /// The file cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The format has no animations.
    #[error("only {} files hold animations; give the file that the scene was baked of ({})", file_format::listed(&endings(), " and "), path.display())]
    NoGltf {
        /// Path of the file.
        path: PathBuf,
    },
    /// No clip is playable.
    #[error(transparent)]
    Unplayable(#[from] AnimationError),
}

/// Extensions of the files that may hold animations.
pub fn endings() -> Vec<&'static str> {
    SceneFormat::all_endings(|format| format.holds(Content::Animations))
}

/// Reads the animation of a file, without pictures. Unusable skins, morph targets and clips are left out, see
/// [`Animation::warnings`].
///
/// # Errors
/// A file that is unreadable, or has no playable clip.
pub fn read(path: &Path, options: &ImportOptions) -> Result<Animation, AnimationFileError> {
    let animation = import::animation(path, options);
    let mut animation = animation.ok_or_else(|| AnimationFileError::NoGltf { path: path.into() })??;
    animation.clip(None).map(drop)?;
    let parting = animation.parting_objects();
    if !parting.is_empty() {
        animation.warnings.push(format!(
            "the objects {} have surfaces that are in one place at rest and move apart, and may follow one another's \
             motion; move them apart at rest, or make them objects of their own",
            listed(&parting)
        ));
    }
    Ok(animation)
}

#[cfg(test)]
mod tests;
