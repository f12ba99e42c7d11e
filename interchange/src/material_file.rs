//! A material in a separate JSON file: like a [`Material`](lapidary_core::material::Material), but its maps name
//! picture files beside it.

use glam::Vec2;
use lapidary_core::{
    material::{Maps, MaterialOf},
    texture::{Channel, ColorSpace, Procedural, TextureSlot, UvSet, Wrap, is_default},
};
use serde::{Deserialize, Serialize};

/// The contents of a material file. An empty name is the file's.
pub type MaterialFile = MaterialOf<SlotFile>;

/// The maps of a [`MaterialFile`].
pub type MapFiles = Maps<SlotFile>;

/// A picture in use; see [`TextureSlot`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlotFile {
    /// The picture, relative to the material file; empty for a pattern.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// A pattern instead of a picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub procedural: Option<Procedural>,
    /// What the texels are; by default [`ColorSpace::Srgb`] for maps of colors, and [`ColorSpace::Linear`] for all others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color_space: Option<ColorSpace>,
    /// Component for scalar parameters.
    #[serde(default)]
    pub channel: Channel,
    /// Repetitions across the unit square.
    #[serde(default = "one")]
    pub scale: Vec2,
    /// Added after scaling and rotating.
    #[serde(default)]
    pub offset: Vec2,
    /// Counter-clockwise rotation of the coordinates in degrees.
    #[serde(default)]
    pub rotation_degrees: f32,
    /// Scales normals and heights.
    #[serde(default = "full_strength")]
    pub strength: f32,
    /// Normals have their green channel down (DirectX).
    #[serde(default)]
    pub flip_y: bool,
    /// Along u and v.
    #[serde(default, skip_serializing_if = "is_default")]
    pub wrap: [Wrap; 2],
    /// The texture coordinates of the surface.
    #[serde(default, skip_serializing_if = "is_default")]
    pub uv_set: UvSet,
}

fn one() -> Vec2 {
    Vec2::ONE
}

fn full_strength() -> f32 {
    1.0
}

impl SlotFile {
    /// The slot of a picture in `file`, which is empty for a pattern.
    pub fn of(slot: &TextureSlot, file: String) -> Self {
        Self {
            file,
            procedural: slot.procedural,
            color_space: Some(slot.color_space),
            channel: slot.channel,
            scale: slot.scale,
            offset: slot.offset,
            rotation_degrees: slot.rotation.to_degrees(),
            strength: slot.strength,
            flip_y: slot.flip_y,
            wrap: slot.wrap,
            uv_set: slot.uv_set,
        }
    }

    /// The name of its picture, unless it is a pattern.
    pub(crate) fn picture(&self) -> Option<&str> {
        self.procedural.is_none().then_some(&self.file)
    }
}
