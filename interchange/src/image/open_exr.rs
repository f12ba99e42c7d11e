//! Decoding of OpenEXR files: the part and the layer that show the whole picture, within the display window, in Rec. 709.
//!
//! The file's data window says where its pixels are, the display window what is shown (OpenEXR, *Technical
//! Introduction*, "Overscan, Display Window and Data Window").

mod alone;
mod choices;

pub(super) use alone::alone;
pub(super) use choices::listed;

use super::{
    primaries,
    read::{check_size, damaged, truncated},
    remark::Remark,
};
use choices::{Choice, Planes};
use exr::{
    image::read::{any_channels::ReadAnyChannels, samples::ReadFlatSamples},
    meta::{MetaData, header::Header},
    prelude::{self as openexr, ReadChannels, ReadLayers},
};
use glam::Vec3;
use lapidary_core::{color::Primaries, image::ImageError, texture::Texels};
use std::{
    io::{Cursor, Read},
    path::Path,
};

/// The first bytes of every OpenEXR file.
pub(super) const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// What the `exr` crate says of a file that ends too early.
const ENDS_EARLY: &str = "reference to missing bytes";

pub(super) fn undecodable(path: &Path, error: exr::error::Error) -> ImageError {
    match &error {
        openexr::Error::Invalid(reason) if reason == ENDS_EARLY => truncated(path, "bytes are missing"),
        openexr::Error::NotSupported(reason) => damaged(path, format!("not supported: {reason}")),
        _ => damaged(path, &error),
    }
}

/// A part of an OpenEXR file, from its header.
#[derive(Clone, Copy, Default)]
pub(super) struct Part {
    /// Pixels of the display window.
    pub pixels: u64,
    /// Bytes of the samples of all channels.
    pub samples: u64,
}

/// The headers of the parts; their sizes are within the limit.
pub(super) fn headers(file: impl Read, path: &Path) -> Result<Vec<Header>, ImageError> {
    let meta = MetaData::read_from_buffered(file, false).map_err(|e| undecodable(path, e))?;
    for header in &meta.headers {
        for size in [header.layer_size, header.shared_attributes.display_window.size] {
            check_size(size.x() as u64, size.y() as u64, path)?;
        }
    }
    Ok(meta.headers.into_iter().collect())
}

impl Part {
    pub fn of(header: &Header) -> Self {
        let area = |size: openexr::Vec2<usize>| size.x() as u64 * size.y() as u64;
        Self {
            pixels: area(header.shared_attributes.display_window.size),
            samples: area(header.layer_size).saturating_mul(header.channels.bytes_per_pixel as u64),
        }
    }
}

/// The data window within the display window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    /// Size of the picture: that of the display window.
    pub size: [u32; 2],
    /// Columns and rows of the data.
    data: [i64; 2],
    /// Column and row of the first sample in the picture.
    first: [i64; 2],
}

impl Window {
    pub fn new(display: openexr::IntegerBounds, data: openexr::IntegerBounds) -> Self {
        let between = |data: i32, display: i32| i64::from(data) - i64::from(display);
        Self {
            size: [display.size.x() as u32, display.size.y() as u32],
            data: [data.size.x() as i64, data.size.y() as i64],
            first: [between(data.position.x(), display.position.x()), between(data.position.y(), display.position.y())],
        }
    }

    /// Number of samples of a channel.
    pub fn samples(&self) -> usize {
        (self.data[0] * self.data[1]) as usize
    }

    /// The picture, row by row from the top, of values by index of the sample.
    pub fn picture<T: Copy>(&self, outside: T, value: impl Fn(usize) -> T) -> Vec<T> {
        let [width, height] = self.size.map(i64::from);
        let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        positions.map(|(x, y)| self.index(x, y).map_or(outside, &value)).collect()
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let [x, y] = [x - self.first[0], y - self.first[1]];
        let is_inside = (0..self.data[0]).contains(&x) && (0..self.data[1]).contains(&y);
        is_inside.then(|| (y * self.data[0] + x) as usize)
    }
}

/// The picture that a file shows by default, or that of a layer, with its alpha. It is black outside the data window. `remarks`
/// gets what of the header is left out.
pub(super) fn decode(
    bytes: &[u8],
    path: &Path,
    layer: Option<&str>,
    remarks: &mut Vec<Remark>,
) -> Result<([u32; 2], Texels), ImageError> {
    let headers = headers(bytes, path)?;
    let choice = match layer {
        Some(layer) => named(&headers, path, layer)?,
        None => shown(&headers, path, remarks)?,
    };
    let file = read_part(bytes, path, &headers[choice.part])?;
    let part = &file.layer_data;
    let window = Window::new(file.attributes.display_window, part.absolute_bounds());
    let found = file.attributes.chromaticities.as_ref().map(primaries::named);
    let colors = Colors::of(&part.channel_data.list, &choice, found.unwrap_or(Primaries::REC_709));
    let colors = colors.filter(|colors| colors.are_whole(window.samples()));
    let colors = colors.ok_or_else(|| damaged(path, "its channels differ in resolution"))?;
    let found = found.filter(|_| !matches!(colors.planes, Planes::Values(_)));
    let to_rec_709 = found.and_then(|found| primaries::rec_709_or_remark(&found, remarks));
    let texel = |i: usize| colors.at(i).extend(colors.alpha_at(i)).to_array();
    Ok((window.size, primaries::texels(window.picture([0.0; 4], texel), to_rec_709)))
}

/// The names of what [`decode`] can show of a file, first what it shows by default.
pub(super) fn names(file: impl Read, path: &Path) -> Result<Vec<String>, ImageError> {
    Ok(choices::all(&headers(file, path)?).into_iter().map(|choice| choice.name).collect())
}

/// The whole name of a layer.
pub(super) fn name(file: impl Read, path: &Path, layer: &str) -> Result<String, ImageError> {
    named(&headers(file, path)?, path, layer).map(|choice| choice.name)
}

fn named(headers: &[Header], path: &Path, layer: &str) -> Result<Choice, ImageError> {
    choices::find(headers, layer).map_err(|has| ImageError::NoLayer { path: path.into(), name: layer.into(), has })
}

/// What is shown without a choice: the whole picture, else the first there is, with a remark.
fn shown(headers: &[Header], path: &Path, remarks: &mut Vec<Remark>) -> Result<Choice, ImageError> {
    if let Some(whole) = choices::whole(headers) {
        return Ok(whole);
    }
    let all = choices::all(headers);
    let first = all.first().cloned().ok_or_else(|| damaged(path, choices::DEEP))?;
    remarks.push(Remark::Layers(all.into_iter().map(|choice| choice.name).collect()));
    Ok(first)
}

type PartOfFile = openexr::Image<openexr::Layer<openexr::AnyChannels<openexr::FlatSamples>>>;

fn read_part(bytes: &[u8], path: &Path, header: &Header) -> Result<PartOfFile, ImageError> {
    let channels = openexr::read().no_deep_data().largest_resolution_level().all_channels();
    OnePart { header, channels }
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| undecodable(path, e))
}

/// Reads all channels of one part. The `exr` crate would read the first one of any content.
struct OnePart<'a> {
    header: &'a Header,
    channels: ReadAnyChannels<ReadFlatSamples>,
}

impl<'s> ReadChannels<'s> for OnePart<'_> {
    type Reader = <ReadAnyChannels<ReadFlatSamples> as ReadChannels<'s>>::Reader;

    fn create_channels_reader(&'s self, header: &Header) -> openexr::Result<Self::Reader> {
        let name = |header: &Header| header.own_attributes.layer_name.clone();
        if name(header) != name(self.header) || header.channels != self.header.channels {
            return Err(openexr::Error::Invalid("another part".into()));
        }
        self.channels.create_channels_reader(header)
    }
}

pub(super) fn words(text: &openexr::Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// The samples of a picture.
struct Colors<'a> {
    planes: Planes<&'a openexr::FlatSamples>,
    alpha: Option<&'a openexr::FlatSamples>,
    /// Luminance of red, green and blue.
    luminance: Vec3,
}

impl<'a> Colors<'a> {
    fn of(
        channels: &'a [openexr::AnyChannel<openexr::FlatSamples>],
        choice: &Choice,
        primaries: Primaries,
    ) -> Option<Self> {
        let named = |name: &String| channels.iter().find(|c| words(&c.name) == *name).map(|c| &c.sample_data);
        let luminance = primaries.luminance().or_else(|| Primaries::REC_709.luminance())?;
        Some(Self { planes: choice.planes.try_map(named)?, alpha: choice.alpha.as_ref().and_then(named), luminance })
    }

    /// Whether all channels have this number of samples.
    fn are_whole(&self, count: usize) -> bool {
        self.planes.channels().iter().chain(&self.alpha).all(|samples| samples.len() == count)
    }

    fn at(&self, index: usize) -> Vec3 {
        let of = |samples: &openexr::FlatSamples| samples.value_by_flat_index(index).to_f32();
        match &self.planes {
            Planes::Rgb(planes) => Vec3::from_array(planes.map(of)),
            Planes::Values(planes) => match planes[..] {
                [gray] => Vec3::splat(of(gray)),
                _ => Vec3::from_array(std::array::from_fn(|i| planes.get(i).map_or(0.0, |plane| of(plane)))),
            },
            Planes::Chroma(planes) => {
                let [y, ry, by] = planes.map(of);
                let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
                Vec3::new(r, (y - self.luminance.x * r - self.luminance.z * b) / self.luminance.y, b)
            }
        }
    }

    fn alpha_at(&self, index: usize) -> f32 {
        self.alpha.map_or(1.0, |alpha| alpha.value_by_flat_index(index).to_f32())
    }
}

#[cfg(test)]
mod tests;
