//! Reads one layer of an OpenEXR file, whether its layers are parts or channel prefixes.

use super::super::{
    open_exr::{self, EXR_MAGIC, Part, Window, undecodable, words},
    read::{Footprint, damaged},
};
use exr::prelude::{self as openexr, ReadChannels, ReadLayers};
use glam::{Mat3, Vec3};
use lapidary_core::{
    color::in_rec_709,
    image::{Image, ImageError},
    input, memory,
};
use std::{io::Cursor, path::Path};

/// Name of the unnamed layer where a name is needed.
const UNNAMED: &str = "beauty";

/// Channels of a layer: their names without the layer's, and their samples.
struct Group {
    name: String,
    window: Window,
    channels: Vec<(String, openexr::FlatSamples)>,
}

/// Reads one layer of an OpenEXR file: its colors in Rec. 709, its vectors, or its single channel repeated. Names match in any
/// case, `-` matches `_`, and the last words of a long name suffice; `beauty` also means the unnamed layer.
///
/// # Errors
/// A file that is unreadable or lacks the layer.
pub fn read_layer(path: &Path, name: &str) -> Result<Image, ImageError> {
    let bytes = input::read(path).map_err(|source| ImageError::Io { action: "read", path: path.into(), source })?;
    let none = |has: String| ImageError::NoLayer { path: path.into(), name: name.into(), has };
    if !bytes.starts_with(&EXR_MAGIC) {
        return Err(none("only exr files have layers".into()));
    }
    let File { groups, to_rec_709 } = File::read(&bytes, path)?;
    let known = || groups.iter().map(|group| group.name.as_str()).collect::<Vec<_>>().join(", ");
    let group = find(&groups, name).ok_or_else(|| none(format!("the file has {}", known())))?;
    group.image(to_rec_709).map_err(|reason| damaged(path, reason))
}

fn find<'a>(groups: &'a [Group], name: &str) -> Option<&'a Group> {
    let wanted = plain(name);
    let suffix = format!(".{wanted}");
    let exact = groups.iter().find(|group| plain(&group.name) == wanted);
    exact.or_else(|| groups.iter().find(|group| plain(&group.name).ends_with(&suffix)))
}

fn plain(name: &str) -> String {
    name.to_ascii_lowercase().replace('-', "_")
}

/// All layers of a file.
struct File {
    groups: Vec<Group>,
    to_rec_709: Option<Mat3>,
}

impl File {
    fn read(bytes: &[u8], path: &Path) -> Result<Self, ImageError> {
        let parts: Vec<Part> = open_exr::headers(bytes, path)?.iter().map(Part::of).collect();
        // All parts are decoded, and one of them becomes a picture.
        let decoding = parts.iter().fold(0, |sum: u64, part| sum.saturating_add(part.samples));
        let held = parts.iter().map(|part| part.pixels.saturating_mul(12)).max().unwrap_or(0);
        Footprint { held, levels: 0, decoding }.check(memory::available(), path)?;
        let file = openexr::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(|e| undecodable(path, e))?;
        let display = file.attributes.display_window;
        let to_rec_709 = open_exr::to_rec_709(file.attributes.chromaticities, path)?;
        let mut groups: Vec<Group> = Vec::new();
        for part in file.layer_data {
            let part_name = part.attributes.layer_name.as_ref().map(words).unwrap_or_default();
            let window = Window::new(display, part.absolute_bounds());
            for channel in part.channel_data.list {
                let full = words(&channel.name);
                let (prefix, channel_name) = full.rsplit_once('.').unwrap_or(("", &full));
                let name = joined(&part_name, prefix);
                let place = groups.iter().position(|group| group.name == name && group.window == window);
                let place = place.unwrap_or_else(|| {
                    groups.push(Group { name, window, channels: Vec::new() });
                    groups.len() - 1
                });
                groups[place].channels.push((channel_name.to_owned(), channel.sample_data));
            }
        }
        Ok(Self { groups, to_rec_709 })
    }
}

/// A part may repeat its name in its channels, as Nuke writes it.
fn joined(part: &str, prefix: &str) -> String {
    match (part, prefix) {
        ("", "") => UNNAMED.into(),
        (part, prefix) if part == prefix || prefix.is_empty() => part.into(),
        ("", prefix) => prefix.into(),
        (part, prefix) => format!("{part}.{prefix}"),
    }
}

impl Group {
    fn image(&self, to_rec_709: Option<Mat3>) -> Result<Image, String> {
        let named = |name: &str| self.channels.iter().find(|(c, _)| c.eq_ignore_ascii_case(name)).map(|(_, s)| s);
        let three = |[a, b, c]: [&str; 3]| Some([named(a)?, named(b)?, named(c)?]);
        let repeated = || if let [(_, only)] = &self.channels[..] { Some([only; 3]) } else { None };
        let colors = three(["R", "G", "B"]);
        let to_rec_709 = to_rec_709.filter(|_| colors.is_some());
        let planes = colors.or_else(|| three(["X", "Y", "Z"])).or_else(repeated).ok_or_else(|| {
            let names: Vec<&str> = self.channels.iter().map(|(name, _)| name.as_str()).collect();
            format!("its layer {} has the channels {} where R, G, B or one are needed", self.name, names.join(", "))
        })?;
        if planes.iter().any(|samples| samples.len() != self.window.samples()) {
            return Err(format!("the channels of its layer {} differ in resolution", self.name));
        }
        let pixel = |i| {
            let value = Vec3::from_array(planes.map(|samples| samples.value_by_flat_index(i).to_f32()));
            to_rec_709.map_or(value, |matrix| in_rec_709(matrix, value))
        };
        Ok(Image { size: self.window.size, pixels: self.window.picture(Vec3::ZERO, pixel) })
    }
}
