//! Pictures to write: checked before the work, written after it.

use crate::export::{LayerKind, LayerList, Studio, Taken, layered, take_layers};
use anyhow::Result;
use lapidary_core::{
    dataset::Dataset,
    image::{Image, ImageError},
};
use lapidary_interchange::{
    formats::{FileFormat, PictureFormat},
    image::{self, Layer},
};
use lapidary_render::{Background, Look};
use std::path::{Path, PathBuf};

/// Checks that each path names a picture format.
///
/// # Errors
/// The first path that does not.
pub fn check_pictures(paths: &[PathBuf]) -> Result<()> {
    for path in paths {
        if !PictureFormat::of(path).is_some_and(PictureFormat::is_written) {
            return Err(ImageError::UnknownExtension { path: path.clone() }.into());
        }
    }
    Ok(())
}

/// Whether a file holds layers.
pub fn is_exr(path: &Path) -> bool {
    has_extension(path, "exr")
}

/// Whether a file's name ends in an extension, in letters of any case.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Writes one picture to all paths, with its coverage as alpha channel if there is one.
///
/// # Errors
/// The first path that cannot be written to; a file that was there before is kept then.
pub fn write_pictures(image: &Image, coverage: Option<&[f32]>, paths: &[PathBuf]) -> Result<()> {
    for path in paths {
        image::write_with(image, coverage, path)?;
    }
    Ok(())
}

/// The layers of a look that are asked for; the picture alone if none are.
///
/// # Errors
/// A part of the light that is not in the picture.
pub fn wanted_layers(list: Option<&LayerList>, look: &Look) -> Result<Vec<LayerKind>> {
    list.map_or_else(|| Ok(vec![LayerKind::Beauty]), |list| list.of(look))
}

/// A picture and its layers, to be written.
pub struct Finished {
    /// The picture.
    pub taken: Taken,
    layers: Vec<Layer>,
}

impl Finished {
    /// Renders them.
    ///
    /// # Errors
    /// As [`Studio::take`].
    pub fn take(studio: &mut Studio, look: &Look, kinds: &[LayerKind], cancelled: &dyn Fn() -> bool) -> Result<Self> {
        let (taken, layers) = take_layers(studio, look, kinds, cancelled)?;
        Ok(Self { taken, layers })
    }

    /// Writes to each path what its extension asks for: an exr gets all layers and says how it was made, a png is as a display
    /// shows it, and an hdr is scene-linear. Where nothing lies behind the scene, exr and png have an alpha channel.
    ///
    /// # Errors
    /// The first path that cannot be written to; a file that was there before is kept then.
    pub fn write(self, look: &Look, dataset: &Dataset, paths: &[PathBuf]) -> Result<()> {
        let Self { taken, layers } = self;
        let transparent = look.view.background == Background::Transparent;
        for path in paths.iter().filter(|path| has_extension(path, "png")) {
            taken.shown.write_png(path)?;
        }
        for path in paths.iter().filter(|path| has_extension(path, "hdr")) {
            let coverage = transparent.then_some(taken.coverage.as_slice());
            image::write_with(&taken.image, coverage, path)?;
        }
        let exr: Vec<&PathBuf> = paths.iter().filter(|path| is_exr(path)).collect();
        let Some((last, others)) = exr.split_last() else { return Ok(()) };
        let image = layered(look, dataset, &taken, layers);
        // Layers may take much memory: only a second file needs a copy.
        others.iter().try_for_each(|path| image.clone().write(path))?;
        Ok(image.write(last)?)
    }
}
