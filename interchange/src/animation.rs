//! Animations of files of scenes.

use crate::{
    file_format::{self, FileFormat},
    import::{self, Content, ImportError, ImportOptions, SceneFormat},
    names::listed,
};
use lapidary_core::animation::{Animation, AnimationError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why no animation can be read.
#[derive(Debug, Error)]
pub enum AnimationFileError {
    /// The file cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A format without animations.
    #[error("only {} files hold animations; give the file that the scene was baked of ({})", file_format::listed(&endings(), " and "), path.display())]
    NoGltf {
        /// The file.
        path: PathBuf,
    },
    /// No clip can be played.
    #[error(transparent)]
    Unplayable(#[from] AnimationError),
}

/// Endings of the files that may hold animations.
pub fn endings() -> Vec<&'static str> {
    SceneFormat::all_endings(|format| format.holds(Content::Animations))
}

/// Reads the animation of a file. Pictures are not read. Skins, morph targets and clips that cannot be used are left out, see
/// [`Animation::warnings`].
///
/// # Errors
/// A file that cannot be read, or has no clip that can be played.
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
