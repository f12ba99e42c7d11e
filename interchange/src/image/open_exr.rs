//! Decoding of OpenEXR files: the part and the layer that show the whole picture, within the display window, in Rec. 709.
//!
//! The file's data window says where its pixels are, the display window what is shown (OpenEXR, *Technical
//! Introduction*, "Overscan, Display Window and Data Window").

use super::{
    primaries,
    read::{check_size, damaged, truncated},
};
use exr::{
    image::read::{any_channels::ReadAnyChannels, samples::ReadFlatSamples},
    meta::{MetaData, attribute::Chromaticities, header::Header},
    prelude::{self as openexr, ReadChannels, ReadLayers},
};
use glam::{Mat3, Vec3};
use lapidary_core::{color::Primaries, image::ImageError, texture::Texels};
use std::{io::Cursor, path::Path};

/// The first bytes of every OpenEXR file.
pub(super) const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Last words of names of layers that hold the whole picture, the best first.
const WHOLE: [&str; 4] = ["beauty", "rgba", "rgb", "combined"];

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
pub(super) fn headers(bytes: &[u8], path: &Path) -> Result<Vec<Header>, ImageError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| undecodable(path, e))?;
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

/// The conversion to Rec. 709 that a file with these primaries needs.
pub(super) fn to_rec_709(found: Option<Chromaticities>, path: &Path) -> Result<Option<Mat3>, ImageError> {
    let unusable = |space| ImageError::Primaries { path: path.into(), space };
    found.map_or(Ok(None), |found| primaries::rec_709_from(&primaries::named(&found))).map_err(unusable)
}

/// The picture with its alpha. It is black outside the data window. `remarks` gets what of the header is left out.
pub(super) fn decode(bytes: &[u8], path: &Path, remarks: &mut Vec<String>) -> Result<([u32; 2], Texels), ImageError> {
    let headers = headers(bytes, path)?;
    let chosen = choose(&headers).map_err(|reason| damaged(path, reason))?;
    let header = &headers[chosen.part];
    let channels = openexr::read().no_deep_data().largest_resolution_level().all_channels();
    let file = OnePart { header, channels }
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| undecodable(path, e))?;
    let layer = &file.layer_data;
    let window = Window::new(file.attributes.display_window, layer.absolute_bounds());
    let named = file.attributes.chromaticities.as_ref().map(primaries::named);
    let colors = Colors::of(&layer.channel_data.list, &chosen.layer, named.unwrap_or(Primaries::REC_709));
    let colors = colors.filter(|colors| colors.are_whole(window.samples()));
    let colors = colors.ok_or_else(|| damaged(path, "its channels differ in resolution"))?;
    let named = named.filter(|_| !colors.are_gray());
    let to_rec_709 = named.and_then(|found| primaries::rec_709_or_remark(&found, remarks));
    let texel = |i: usize| colors.at(i).extend(colors.alpha_at(i)).to_array();
    Ok((window.size, primaries::texels(window.picture([0.0; 4], texel), to_rec_709)))
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

/// The layer that is read: its part, and the prefix of its channels.
#[derive(Debug, PartialEq)]
struct Chosen {
    part: usize,
    layer: String,
}

/// The layer of colors that shows the whole picture: the unnamed one, else one with a usual name, else the first.
fn choose(headers: &[Header]) -> Result<Chosen, String> {
    let mut best: Option<(usize, Chosen)> = None;
    let flat = || headers.iter().enumerate().filter(|(_, header)| !header.deep);
    for (part, header) in flat() {
        let part_name = header.own_attributes.layer_name.as_ref().map(words).unwrap_or_default();
        let part_name = if headers.len() == 1 { "" } else { &part_name };
        for (layer, channels) in layers(header) {
            let has = |name: &&str| channels.iter().any(|channel| channel.eq_ignore_ascii_case(name));
            let rank = 2 * rank(part_name, &layer);
            let rank = match (["R", "G", "B"].iter().all(has), has(&"Y")) {
                (true, _) => rank,
                // A layer of one channel may hold depth or anything else, unless its name says otherwise: the last choice.
                (false, true) if rank <= 2 * WHOLE.len() => rank + 1,
                (false, true) if layer.is_empty() => usize::MAX,
                _ => continue,
            };
            if best.as_ref().is_none_or(|(other, _)| rank < *other) {
                best = Some((rank, Chosen { part, layer }));
            }
        }
    }
    best.map(|(_, chosen)| chosen).ok_or_else(|| {
        let names: Vec<String> = flat().flat_map(|(_, header)| &header.channels.list).map(|c| words(&c.name)).collect();
        match names.is_empty() {
            true => "deep pixels are not supported".into(),
            false => format!("it has the channels {} where R, G, B or Y are needed", names.join(", ")),
        }
    })
}

/// Place of a layer in the order of preference.
fn rank(part: &str, layer: &str) -> usize {
    let name = if layer.is_empty() { part } else { layer };
    let name = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    match WHOLE.iter().position(|whole| *whole == name) {
        _ if name.is_empty() => 0,
        Some(place) => 1 + place,
        None if layer.is_empty() => 1 + WHOLE.len(),
        None if name == "diffuse" => 2 + WHOLE.len(),
        None => 3 + WHOLE.len(),
    }
}

/// The layers of a part, by prefix, with the names of their channels.
fn layers(header: &Header) -> Vec<(String, Vec<String>)> {
    let mut layers: Vec<(String, Vec<String>)> = Vec::new();
    for channel in &header.channels.list {
        let full = words(&channel.name);
        let (layer, channel) = full.rsplit_once('.').unwrap_or(("", &full));
        match layers.iter_mut().find(|(name, _)| name == layer) {
            Some((_, channels)) => channels.push(channel.into()),
            None => layers.push((layer.into(), vec![channel.into()])),
        }
    }
    layers
}

pub(super) fn words(text: &openexr::Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// The channels of a layer that make a color.
struct Colors<'a> {
    planes: Planes<'a>,
    alpha: Option<&'a openexr::FlatSamples>,
}

enum Planes<'a> {
    Rgb([&'a openexr::FlatSamples; 3]),
    Gray(&'a openexr::FlatSamples),
    /// Luminance Y and the chroma (R - Y) / Y and (B - Y) / Y, with the luminance of red, green and blue.
    Chroma([&'a openexr::FlatSamples; 3], Vec3),
}

impl<'a> Colors<'a> {
    fn of(
        channels: &'a [openexr::AnyChannel<openexr::FlatSamples>],
        layer: &str,
        primaries: Primaries,
    ) -> Option<Self> {
        let named = |name: &str| {
            let full = if layer.is_empty() { name.to_owned() } else { format!("{layer}.{name}") };
            channels.iter().find(|c| c.name.eq_case_insensitive(&full)).map(|c| &c.sample_data)
        };
        let three = |[a, b, c]: [&str; 3]| Some([named(a)?, named(b)?, named(c)?]);
        let chroma = || {
            Some(Planes::Chroma(
                three(["Y", "RY", "BY"])?,
                primaries.luminance().or_else(|| Primaries::REC_709.luminance())?,
            ))
        };
        let rgb = three(["R", "G", "B"]).map(Planes::Rgb);
        let planes = rgb.or_else(chroma).or_else(|| named("Y").map(Planes::Gray))?;
        Some(Self { planes, alpha: named("A") })
    }

    /// Whether all channels have this number of samples.
    fn are_whole(&self, count: usize) -> bool {
        let planes = match &self.planes {
            Planes::Rgb(planes) | Planes::Chroma(planes, _) => &planes[..],
            Planes::Gray(plane) => std::slice::from_ref(plane),
        };
        planes.iter().copied().chain(self.alpha).all(|samples| samples.len() == count)
    }

    fn are_gray(&self) -> bool {
        matches!(self.planes, Planes::Gray(_))
    }

    fn at(&self, index: usize) -> Vec3 {
        let of = |samples: &openexr::FlatSamples| samples.value_by_flat_index(index).to_f32();
        match self.planes {
            Planes::Rgb(planes) => Vec3::from_array(planes.map(of)),
            Planes::Gray(plane) => Vec3::splat(of(plane)),
            Planes::Chroma(planes, luminance) => {
                let [y, ry, by] = planes.map(of);
                let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
                Vec3::new(r, (y - luminance.x * r - luminance.z * b) / luminance.y, b)
            }
        }
    }

    fn alpha_at(&self, index: usize) -> f32 {
        self.alpha.map_or(1.0, |alpha| alpha.value_by_flat_index(index).to_f32())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{decode, read_layer};
    use exr::prelude::WritableImage;
    use lapidary_core::texture::Texture;

    type Plane = (&'static str, f32);

    /// A part of 2 x 2 pixels with one value per channel.
    fn part(name: Option<&str>, channels: &[Plane]) -> openexr::Layer<openexr::AnyChannels<openexr::FlatSamples>> {
        let plane = |&(name, value): &Plane| openexr::AnyChannel::new(name, openexr::FlatSamples::F32(vec![value; 4]));
        let attributes = name.map_or_else(Default::default, openexr::LayerAttributes::named);
        let channels = openexr::AnyChannels::sort(channels.iter().map(plane).collect());
        openexr::Layer::new((2, 2), attributes, openexr::Encoding::UNCOMPRESSED, channels)
    }

    fn written(parts: Vec<openexr::Layer<openexr::AnyChannels<openexr::FlatSamples>>>) -> Vec<u8> {
        let attributes = openexr::ImageAttributes::new(openexr::IntegerBounds::from_dimensions((2, 2)));
        let mut bytes = Cursor::new(Vec::new());
        let file = openexr::Image::from_layers(attributes, parts);
        file.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> Result<Texture, String> {
        decode(bytes, Path::new("a.exr")).map_err(|e| e.to_string())
    }

    fn first(bytes: &[u8]) -> [f32; 4] {
        read(bytes).unwrap().texel(0, 0, Default::default()).to_array()
    }

    /// A ramp of data at a position in a display window of 8 x 4 pixels whose first pixel is (100, -50).
    fn windowed(position: [i32; 2], size: [usize; 2]) -> Vec<u8> {
        let channels = openexr::SpecificChannels::rgb(move |at: openexr::Vec2<usize>| {
            let [x, y] = [at.x() as i32 + position[0], at.y() as i32 + position[1]];
            let is_shown = (0..8).contains(&x) && (0..4).contains(&y);
            if is_shown { (x as f32, y as f32, 1.0) } else { (9.0, 9.0, 9.0) }
        });
        let mut image = openexr::Image::from_channels((size[0], size[1]), channels);
        image.layer_data.attributes.layer_position = openexr::Vec2(100 + position[0], position[1] - 50);
        image.attributes.display_window = openexr::IntegerBounds::new((100, -50), (8, 4));
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn a_picture_has_its_display_window_and_is_black_outside_its_data() {
        let texture = read(&windowed([2, 1], [4, 2])).unwrap();
        assert_eq!(texture.size, [8, 4]);
        let Texels::F32(texels) = &texture.texels else { panic!("exr holds floats") };
        for (i, texel) in texels.iter().enumerate() {
            let [x, y] = [i % 8, i / 8];
            let is_inside = (2..6).contains(&x) && (1..3).contains(&y);
            let expected = if is_inside { [x as f32, y as f32, 1.0, 1.0] } else { [0.0; 4] };
            assert_eq!(*texel, expected, "{x} {y}");
        }
        assert_eq!(texels.iter().filter(|texel| texel[3] == 0.0).count(), 24, "negative control");
    }

    #[test]
    fn overscan_is_cut_away_also_from_layers() {
        let bytes = windowed([-3, -2], [14, 9]);
        let texture = read(&bytes).unwrap();
        let Texels::F32(texels) = &texture.texels else { panic!("exr holds floats") };
        assert_eq!(texture.size, [8, 4]);
        let ramp = |i: usize| [(i % 8) as f32, (i / 8) as f32, 1.0, 1.0];
        assert!(texels.iter().enumerate().all(|(i, texel)| *texel == ramp(i)), "{texels:?}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, &bytes).unwrap();
        let layer = read_layer(&path, "beauty").unwrap();
        assert_eq!((layer.size, layer.at(7, 3)), ([8, 4], Vec3::new(7.0, 3.0, 1.0)));
        let whole = read(&windowed([0, 0], [8, 4])).unwrap();
        assert_eq!(whole.texels, texture.texels, "the same picture without overscan");
    }

    #[test]
    fn the_layer_of_the_whole_picture_is_shown_whatever_its_name() {
        let rgb = |layer: &'static str, value: f32| -> Vec<Plane> {
            let names: [&str; 3] = match layer {
                "" => ["R", "G", "B"],
                "beauty" => ["beauty.R", "beauty.G", "beauty.B"],
                "ViewLayer.Combined" => ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"],
                "diffuse" => ["diffuse.r", "diffuse.g", "diffuse.b"],
                _ => ["albedo.R", "albedo.G", "albedo.B"],
            };
            names.map(|name| (name, value)).to_vec()
        };
        let order = ["", "beauty", "ViewLayer.Combined", "diffuse", "albedo"];
        for shown in 0..order.len() {
            let channels: Vec<Plane> = (shown..order.len()).rev().flat_map(|i| rgb(order[i], i as f32)).collect();
            let bytes = written(vec![part(None, &channels)]);
            assert_eq!(first(&bytes), [shown as f32, shown as f32, shown as f32, 1.0], "{}", order[shown]);
        }
    }

    #[test]
    fn the_part_with_colours_is_read_and_a_usual_name_comes_first() {
        let depth = || part(Some("depth"), &[("Z", 7.0)]);
        let colors = |name, value| part(Some(name), &[("R", value), ("G", value), ("B", value), ("A", 0.5)]);
        let shown = |parts| first(&written(parts));
        assert_eq!(shown(vec![depth(), colors("left", 1.0), colors("right", 2.0)]), [1.0, 1.0, 1.0, 0.5]);
        assert_eq!(shown(vec![colors("left", 1.0), depth(), colors("rgba", 2.0)]), [2.0, 2.0, 2.0, 0.5]);
        let gray = |name, value| part(Some(name), &[("Y", value)]);
        assert_eq!(shown(vec![gray("height", 3.0), gray("mask", 4.0)]), [3.0, 3.0, 3.0, 1.0], "the first of grays");
        assert_eq!(shown(vec![gray("height", 3.0), colors("left", 1.0)]), [1.0, 1.0, 1.0, 0.5], "colors before grays");
        let message = read(&written(vec![depth(), part(Some("more"), &[("id", 1.0)])])).unwrap_err();
        assert!(message.contains("Z") && message.contains("id"), "{message}");
    }

    #[test]
    fn luminance_and_chroma_become_colours() {
        // R, G, B = 0.5, 0.25, 1.0 with the luminance of Rec. 709.
        let [r, g, b] = [0.5, 0.25, 1.0];
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let bytes = written(vec![part(None, &[("Y", y), ("RY", (r - y) / y), ("BY", (b - y) / y)])]);
        let found = Vec3::from_slice(&first(&bytes));
        assert!((found - Vec3::new(r, g, b)).abs().max_element() < 1e-3, "{found}");
        assert_eq!(first(&written(vec![part(None, &[("Y", y)])])), [y, y, y, 1.0], "negative control: gray");
    }
}
