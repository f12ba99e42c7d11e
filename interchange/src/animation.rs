//! Animations of glTF and GLB files.

use crate::{
    import::{self, ImportError, ImportOptions},
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
    #[error("only .gltf and .glb files hold animations; give the file that the scene was baked of ({})", path.display())]
    NoGltf {
        /// The file.
        path: PathBuf,
    },
    /// No clip can be played.
    #[error(transparent)]
    Unplayable(#[from] AnimationError),
}

/// Reads the animation of a file. Pictures are not read. Skins, morph targets and clips that cannot be used are left out, see
/// [`Animation::warnings`].
///
/// # Errors
/// A file that cannot be read, or has no clip that can be played.
pub fn read(path: &Path, options: &ImportOptions) -> Result<Animation, AnimationFileError> {
    if !import::is_gltf(path) {
        return Err(AnimationFileError::NoGltf { path: path.into() });
    }
    let mut animation = import::animation(path, options)?;
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
