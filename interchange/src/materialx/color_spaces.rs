//! Names of color spaces (MaterialX specification 1.39, "Color Spaces and Color Management Systems").

use super::graph::holds_floats;
use glam::Vec3;
use lapidary_core::{color::linear_from_srgb, texture::ColorSpace};

/// Names of values that are taken as they are, whatever a file says of its colors; the first is written.
const RAW: [&str; 2] = ["raw", "none"];

/// The names of a color space in lower case; the first is written.
const SPACES: [(ColorSpace, &[&str]); 6] = [
    (ColorSpace::Srgb, &["srgb_texture", "srgb"]),
    (ColorSpace::Linear, &["lin_rec709", "linear", "lin_srgb", RAW[0], RAW[1], ""]),
    (ColorSpace::AcesCg, &["acescg", "lin_ap1", "lin_ap1_scene"]),
    (ColorSpace::Aces2065, &["lin_ap0", "lin_ap0_scene", "aces2065_1", "aces2065-1"]),
    (ColorSpace::Rec2020, &["lin_rec2020", "lin_rec2020_scene"]),
    (ColorSpace::P3, &["lin_displayp3", "lin_p3d65", "lin_p3d65_scene"]),
];

/// The color space of a name in any case.
pub fn named(name: &str) -> Option<ColorSpace> {
    let name = name.trim().to_ascii_lowercase();
    SPACES.iter().find(|(_, names)| names.contains(&name.as_str())).map(|(space, _)| *space)
}

/// The color space of a picture that a document calls so. What float pictures say of their own colors counts, unless the name
/// says that they are values.
pub fn of_picture(space: ColorSpace, name: &str, file: &str) -> ColorSpace {
    let is_raw = RAW.iter().any(|raw| name.trim().eq_ignore_ascii_case(raw));
    if space == ColorSpace::Linear && holds_floats(file) && !is_raw { ColorSpace::Srgb } else { space }
}

/// The name that is written for a picture of colors; none where the document's own or the file says it.
pub fn written(space: ColorSpace, file: &str) -> Option<&'static str> {
    match (space, holds_floats(file)) {
        (ColorSpace::Srgb, true) | (ColorSpace::Linear, false) => None,
        (ColorSpace::Linear, true) => Some(RAW[0]),
        _ => SPACES.iter().find(|(other, _)| *other == space).map(|(_, names)| names[0]),
    }
}

/// A color of this space in linear Rec. 709.
pub fn in_rec_709(space: ColorSpace, color: [f32; 3]) -> [f32; 3] {
    match (space, space.to_rec_709()) {
        (ColorSpace::Srgb, _) => color.map(linear_from_srgb),
        (_, Some(to_rec_709)) => (to_rec_709 * Vec3::from_array(color)).to_array(),
        (_, None) => color,
    }
}
