//! Pictures of named layers in one part of an OpenEXR file. Channels are called `LAYER.CHANNEL`, which Nuke and Blender
//! group by layer. The unnamed layer has `R`, `G`, `B` and `A`, which every program shows.

mod metadata;

pub(super) use metadata::text;
pub use metadata::{MetaValue, Metadata};

use super::primaries::chromaticities;
use exr::prelude::{self as openexr, WritableImage};
use lapidary_core::{
    color::Primaries,
    image::{Image, ImageError},
    output::write_atomically,
};
use std::{
    io::{self, Cursor},
    path::Path,
};

/// How all layers are written.
pub(super) const LOSSLESS: openexr::Encoding =
    openexr::Encoding { compression: openexr::Compression::ZIP16, ..openexr::Encoding::SMALL_LOSSLESS };

/// A layer: channels by name, each with one value per pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Its name; empty for the layer that programs show first.
    pub name: String,
    /// Channel names without the layer's name, and values.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Layer {
    /// Colors in the channels `R`, `G` and `B`.
    pub fn color(name: &str, image: &Image) -> Self {
        Self::of_three(name, ["R", "G", "B"], image)
    }

    /// Vectors in the channels `X`, `Y` and `Z`.
    pub fn vectors(name: &str, image: &Image) -> Self {
        Self::of_three(name, ["X", "Y", "Z"], image)
    }

    /// One channel.
    pub fn scalar(name: &str, channel: &str, values: Vec<f32>) -> Self {
        Self { name: name.into(), channels: vec![(channel.into(), values)] }
    }

    /// The layer with a channel `A`, by which colors are premultiplied.
    pub fn with_alpha(mut self, coverage: &[f32]) -> Self {
        self.channels.push(("A".into(), coverage.to_vec()));
        self
    }

    fn of_three(name: &str, channels: [&str; 3], image: &Image) -> Self {
        let plane = |i: usize| image.pixels.iter().map(|pixel| pixel[i]).collect();
        let channels = channels.iter().enumerate().map(|(i, channel)| (channel.to_string(), plane(i))).collect();
        Self { name: name.into(), channels }
    }
}

/// A scene-linear picture of layers, with metadata.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredImage {
    /// Width and height of all layers in pixels.
    pub size: [u32; 2],
    /// The layers.
    pub layers: Vec<Layer>,
    /// Its metadata.
    pub metadata: Metadata,
}

impl LayeredImage {
    /// Writes an OpenEXR file (32-bit float, Rec. 709 primaries) under a temporary name, and renames it when complete.
    ///
    /// # Errors
    /// A file that cannot be written; an old file then stays.
    ///
    /// # Panics
    /// If the length of a channel is not one value per pixel.
    pub fn write(self, path: &Path) -> Result<(), ImageError> {
        let failed = |source| ImageError::Io { action: "write", path: path.into(), source };
        write_atomically(path, &self.encode().map_err(failed)?).map_err(failed)
    }

    /// The bytes of the file.
    pub(super) fn encode(self) -> io::Result<Vec<u8>> {
        let size = self.size.map(|side| side as usize);
        let attributes = self.metadata.attributes(self.size);
        let channels = self.layers.into_iter().flat_map(|Layer { name, channels }| {
            channels.into_iter().map(move |(channel, values)| {
                assert_eq!(values.len(), size[0] * size[1], "one value per pixel in {name}.{channel}");
                openexr::AnyChannel::new(file_name(&name, &channel), openexr::FlatSamples::F32(values))
            })
        });
        // 16-bit floats would clip a sun above 65,504.
        let channels = openexr::AnyChannels::sort(channels.collect());
        let layer = openexr::Layer::new((size[0], size[1]), attributes, LOSSLESS, channels);
        let mut image = openexr::Image::from_layer(layer);
        image.attributes.chromaticities = Some(chromaticities(&Primaries::REC_709));
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).map_err(io::Error::other)?;
        Ok(bytes.into_inner())
    }
}

/// Name of a channel in a file.
fn file_name(layer: &str, channel: &str) -> openexr::Text {
    let name = if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") };
    text(&name)
}

#[cfg(test)]
mod tests;
