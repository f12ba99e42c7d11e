//! What the vertices give a material at a point of a surface.

use crate::texture::{TextureSlot, UvFootprint};
use glam::{Vec2, Vec3};

/// Interpolated attributes of a point, for the maps and colors of its material. Twin of `SurfaceAttributes` in
/// `shaders/surface.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceAttributes {
    /// Texture coordinates of both sets, and a sample's footprint in them.
    pub uv: [UvFootprint; 2],
    /// Linear Rec. 709 color; white where the mesh has none.
    pub color: Vec3,
}

impl SurfaceAttributes {
    /// The coordinates that a slot transforms.
    #[inline]
    pub fn uv_of(&self, slot: &TextureSlot) -> &UvFootprint {
        &self.uv[slot.uv_set as usize]
    }
}

impl From<UvFootprint> for SurfaceAttributes {
    /// One set of coordinates, and no color.
    fn from(uv: UvFootprint) -> Self {
        Self { uv: [uv; 2], color: Vec3::ONE }
    }
}

impl From<Vec2> for SurfaceAttributes {
    fn from(uv: Vec2) -> Self {
        UvFootprint::from(uv).into()
    }
}
