//! One layer of an OpenEXR file as a file of its own, which shows it without a choice. Datasets and exports hold it: they need
//! no other layers, and other programs know no names of layers.

use super::{Choice, Planes, headers, named, read_part, words};
use crate::image::layers::{LOSSLESS, text};
use exr::prelude::{self as openexr, WritableImage};
use lapidary_core::image::ImageError;
use std::{io::Cursor, path::Path};

type Channels = openexr::SmallVec<[openexr::AnyChannel<openexr::FlatSamples>; 4]>;

/// The bytes of the file; `None` if the given ones have nothing else and show the layer by default.
///
/// # Errors
/// Contents that are damaged, or without the layer.
pub fn alone(bytes: &[u8], path: &Path, layer: &str) -> Result<Option<Vec<u8>>, ImageError> {
    let headers = headers(bytes, path)?;
    let choice = named(&headers, path, layer)?;
    let is_shown = super::choices::whole(&headers).is_some_and(|whole| whole == choice);
    if is_shown && headers.len() == 1 && headers[0].channels.list.len() == choice.channels().count() {
        return Ok(None);
    }
    let mut file = read_part(bytes, path, &headers[choice.part])?;
    let part = &mut file.layer_data;
    part.encoding = LOSSLESS;
    // The name finds it again in a file that has no other.
    part.attributes.layer_name = Some(text(&choice.name));
    part.channel_data = openexr::AnyChannels::sort(renamed(std::mem::take(&mut part.channel_data.list), &choice));
    if let Planes::Values(_) = choice.planes {
        // Values have no primaries.
        file.attributes.chromaticities = None;
    }
    let mut bytes = Cursor::new(Vec::new());
    file.write().to_buffered(&mut bytes).map_err(|e| super::undecodable(path, e))?;
    Ok(Some(bytes.into_inner()))
}

/// The channels of a choice by the names that programs show without a choice.
fn renamed(channels: Channels, choice: &Choice) -> Channels {
    let names: &[&str] = match &choice.planes {
        Planes::Chroma(_) => &["Y", "RY", "BY"],
        Planes::Values(channels) if channels.len() == 1 => &["Y"],
        Planes::Rgb(_) | Planes::Values(_) => &["R", "G", "B"],
    };
    let from = choice.planes.channels().iter().chain(&choice.alpha);
    let to = || names.iter().take(choice.planes.channels().len()).chain(choice.alpha.as_ref().map(|_| &"A"));
    let new_name = |channel: &openexr::Text| from.clone().zip(to()).find(|(old, _)| **old == words(channel));
    let kept = channels.into_iter().filter_map(|channel| {
        let (_, name) = new_name(&channel.name)?;
        Some(openexr::AnyChannel { name: text(name), ..channel })
    });
    let mut kept: Channels = kept.collect();
    if let (Planes::Values(channels), Some(first)) = (&choice.planes, kept.first())
        && channels.len() == 2
    {
        let zeros = openexr::FlatSamples::F32(vec![0.0; first.sample_data.len()]);
        kept.push(openexr::AnyChannel::new(text("B"), zeros));
    }
    kept
}
