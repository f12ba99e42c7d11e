//! Output pictures: checked before the work, written after it.

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
/// The first path that does not name one.
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

/// Whether a file name ends in an extension, ignoring case.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Writes one picture to all paths, with its coverage as alpha channel if given.
///
/// # Errors
/// The first unwritable path; an existing file there is kept.
pub fn write_pictures(image: &Image, coverage: Option<&[f32]>, paths: &[PathBuf]) -> Result<()> {
    for path in paths {
        image::write_with(image, coverage, path)?;
    }
    Ok(())
}

/// The requested layers of a look; the picture alone if none are requested.
///
/// # Errors
/// A light component that is not in the picture.
pub fn wanted_layers(list: Option<&LayerList>, look: &Look) -> Result<Vec<LayerKind>> {
    list.map_or_else(|| Ok(vec![LayerKind::Beauty]), |list| list.of(look))
}

/// A picture and its layers, ready to write.
pub struct Finished {
    /// The picture.
    pub taken: Taken,
    layers: Vec<Layer>,
}

impl Finished {
    /// Renders the picture and its layers.
    ///
    /// # Errors
    /// As [`Studio::take`].
    pub fn take(studio: &mut Studio, look: &Look, kinds: &[LayerKind], cancelled: &dyn Fn() -> bool) -> Result<Self> {
        let (taken, layers) = take_layers(studio, look, kinds, cancelled)?;
        Ok(Self { taken, layers })
    }

    /// Writes each path by its extension: exr with all layers and metadata, png as displayed, hdr scene-linear. With a transparent
    /// background, exr and png have an alpha channel.
    ///
    /// # Errors
    /// The first unwritable path; an existing file there is kept.
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
        // Layers may take much memory, so only a second file gets a copy.
        others.iter().try_for_each(|path| image.clone().write(path))?;
        Ok(image.write(last)?)
    }
}
