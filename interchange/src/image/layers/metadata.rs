//! Metadata of a picture, in the attributes of OpenEXR.

use exr::{meta::attribute::AttributeValue, prelude as openexr};
use glam::{Mat4, Vec3};
use lapidary_core::camera::Camera;

/// A value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum MetaValue {
    /// Text or JSON.
    Text(String),
    /// A number.
    Number(f64),
    /// Three numbers: a place in meters, or a color.
    Vector(Vec3),
}

/// Metadata of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// The program that made it, with its version.
    pub software: Option<String>,
    /// The camera of the picture; becomes the standard attributes `worldToCamera`, `screenWindowWidth` and the fields
    /// of view.
    pub camera: Option<Camera>,
    /// Other attributes by name.
    pub entries: Vec<(String, MetaValue)>,
}

impl Metadata {
    /// The attributes for a picture of `size` pixels.
    pub(super) fn attributes(&self, size: [u32; 2]) -> openexr::LayerAttributes {
        let other = self.entries.iter().map(|(name, value)| (text(name), value.attribute())).collect();
        let software_name = self.software.as_deref().map(text);
        let mut attributes = openexr::LayerAttributes { software_name, other, ..Default::default() };
        if let Some(camera) = &self.camera {
            let aspect = size[0] as f32 / size[1].max(1) as f32;
            let width = 2.0 * camera.tan_half_fov() * aspect;
            attributes.world_to_camera = Some(camera_from_world(camera).to_cols_array());
            attributes.screen_window_width = width;
            attributes.vertical_field_of_view = Some(camera.fov_y.to_degrees());
            attributes.horizontal_field_of_view = Some(2.0 * (0.5 * width).atan().to_degrees());
        }
        attributes
    }
}

/// Matrix from world to camera space: right, up and backward. It is stored by columns, because OpenEXR multiplies rows
/// from the left.
fn camera_from_world(camera: &Camera) -> Mat4 {
    let turn = camera.world_from_view().transpose();
    Mat4::from_mat3(turn) * Mat4::from_translation(-camera.eye)
}

impl MetaValue {
    fn attribute(&self) -> AttributeValue {
        match self {
            Self::Text(words) => AttributeValue::Text(text(words)),
            Self::Number(number) => AttributeValue::F64(*number),
            Self::Vector(v) => AttributeValue::FloatVec3((v.x, v.y, v.z)),
        }
    }
}

/// A string of OpenEXR, in UTF-8.
pub(in super::super) fn text(words: &str) -> openexr::Text {
    openexr::Text::from_slice_unchecked(words.as_bytes())
}
