//! Names of color spaces (MaterialX specification 1.39, "Color Spaces and Color Management Systems").

use super::graph::holds_floats;
use glam::Vec3;
use lapidary_core::{color::linear_from_srgb, texture::ColorSpace};

/// The names of a color space; the first is written.
const SPACES: [(ColorSpace, &[&str]); 6] = [
    (ColorSpace::Srgb, &["srgb_texture", "sRGB", "srgb"]),
    (ColorSpace::Linear, &["lin_rec709", "linear", "lin_srgb", "none", "raw", ""]),
    (ColorSpace::AcesCg, &["acescg", "lin_ap1", "lin_ap1_scene"]),
    (ColorSpace::Aces2065, &["lin_ap0", "lin_ap0_scene", "aces2065_1"]),
    (ColorSpace::Rec2020, &["lin_rec2020", "lin_rec2020_scene"]),
    (ColorSpace::P3, &["lin_displayp3", "lin_p3d65", "lin_p3d65_scene"]),
];

/// The color space of a name.
pub fn named(name: &str) -> Option<ColorSpace> {
    SPACES.iter().find(|(_, names)| names.contains(&name)).map(|(space, _)| *space)
}

/// The name that is written for a picture; none where the document's own or the file says it.
pub fn written(space: ColorSpace, file: &str) -> Option<&'static str> {
    let is_said = space == ColorSpace::Linear || space == ColorSpace::Srgb && holds_floats(file);
    SPACES.iter().find(|(other, _)| *other == space && !is_said).map(|(_, names)| names[0])
}

/// A color of this space in linear Rec. 709.
pub fn in_rec_709(space: ColorSpace, color: [f32; 3]) -> [f32; 3] {
    match (space, space.to_rec_709()) {
        (ColorSpace::Srgb, _) => color.map(linear_from_srgb),
        (_, Some(to_rec_709)) => (to_rec_709 * Vec3::from_array(color)).to_array(),
        (_, None) => color,
    }
}
