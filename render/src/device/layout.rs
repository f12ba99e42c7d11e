//! The data that the shaders read, byte for byte. A test reflects every struct of the shaders and compares it with
//! these.

pub mod constants;
mod light;
mod rays;

pub use {light::*, rays::*};

use bytemuck::{Pod, Zeroable};

/// `FrameUniforms` of `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FrameUniforms {
    /// For the rasterizer, with the jitter of the sample; depth 1 at the near plane, 0 at infinity.
    pub clip_from_world: [[f32; 4]; 4],
    /// Right, up and backward axes, each padded to 16 bytes.
    pub world_from_view: [[f32; 4]; 3],
    pub eye: [f32; 3],
    pub tan_half_fov: f32,
    pub pixel_offset: [f32; 2],
    pub size: [u32; 2],
    pub background_color: [f32; 3],
    pub background: u32,
    /// Sine and cosine.
    pub environment_turn: [f32; 2],
    pub environment_intensity: f32,
    pub leaf_solid_angle: f32,
    pub tree_height: u32,
    pub view_mode: u32,
    pub wireframe: u32,
    pub source_tree_height: u32,
    pub sample: u32,
    /// First triangle of a ground that catches shadows, [`u32::MAX`] without one.
    pub catcher: u32,
    /// Columns and rows of pixels from texel to texel of the passes that shade.
    pub stride: [u32; 2],
    pub caught_color: [f32; 3],
    pub caught: u32,
    pub caught_per_radiance: [f32; 3],
    pub lets_light_through: u32,
    pub share_weights: [f32; 3],
    /// Height of the finest level of the map that sharp lobes read; 0 for none.
    pub mirrored_height: u32,
    pub shows_emission: u32,
    pub sample_distance: f32,
    /// Flags `SEEN_...`.
    pub seen: u32,
    pub brightest: f32,
    pub picture_sample: u32,
    pub of_lobe: f32,
    pub picture_stride: [u32; 2],
    pub center: [f32; 2],
    pub padding: [u32; 2],
}

/// `Sun` of `sun_rays.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Sun {
    pub axis: [f32; 3],
    pub height: f32,
    pub right: [f32; 3],
    pub sine: f32,
    pub up: [f32; 3],
    pub tangent: f32,
}

/// `SunUniforms` of `sun_rays.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct SunUniforms {
    pub suns: [Sun; constants::MOST_SUNS],
    pub count: u32,
    /// In meters.
    pub largest_offset: f32,
    pub padding: [u32; 2],
}

/// `MirroredScene` of `mirrored_surface_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MirroredScene {
    /// First triangle of a ground, [`u32::MAX`] without one.
    pub ground: u32,
    pub shows_ground: u32,
    pub largest_offset: f32,
    pub padding: u32,
}

/// `PastUniforms` of `predict_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PastUniforms {
    /// Right, up and backward axes, each padded to 16 bytes.
    pub world_from_view: [[f32; 4]; 3],
    pub eye: [f32; 3],
    /// Distance of the picture plane from the eye in pixels.
    pub focal: f32,
    /// Where the axis meets the picture, from the sample of the first pixel.
    pub center: [f32; 2],
    pub size: [u32; 2],
}

/// `Vertex` of `scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Vertex {
    pub position: [f32; 3],
    pub cut_offset: u32,
    pub normal: [f32; 3],
    pub cut_len: u32,
    pub tangent: [f32; 3],
    pub handedness: f32,
    pub uv: [f32; 2],
    pub is_valid: u32,
    pub source_cut_offset: u32,
    pub second_uv: [f32; 2],
    /// Three fractions of 16 bits.
    pub color: [u32; 2],
}

/// `Triangle` of `scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Triangle {
    pub vertices: [u32; 3],
    /// Bit 31: two-sided; the rest: index of the material.
    pub material: u32,
}

/// `TextureSlot` of `materials.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct TextureSlot {
    pub first: u32,
    pub width: u32,
    pub height: u32,
    pub kind: u32,
    pub scale: [f32; 2],
    pub offset: [f32; 2],
    /// Sine and cosine.
    pub turn: [f32; 2],
    pub strength: f32,
    /// Component, wrap along u and v, and set of coordinates.
    pub lookup: u32,
    /// Values of a pattern.
    pub low: [f32; 3],
    pub pattern: u32,
    pub high: [f32; 3],
    pub octaves: u32,
}

/// `MaterialParameter` of `materials.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct MaterialParameter {
    pub value: [f32; 3],
    /// 1 if the colors of the vertices multiply it.
    pub has_vertex_color: u32,
    pub map: TextureSlot,
}

/// `Material` of `materials.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Material {
    pub model: u32,
    pub reads: u32,
    /// Index of the first parameter of surfaces.
    pub surface: u32,
    /// First word of its measured BRDF.
    pub table: u32,
    /// Albedo for light from the normal, and width of the lobe, of a BRDF that is known by its values.
    pub estimate: [f32; 4],
    pub normal_map: TextureSlot,
    pub bump_map: TextureSlot,
    pub parameters: [MaterialParameter; constants::MOST_PARAMETERS],
}

/// `Tables` of `materials.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Tables {
    pub linear_from_srgb: [f32; 256],
    /// As [`lapidary_core::brdf::albedo_table`] has them.
    pub albedo: [[f32; 8]; 304],
}

/// `Node` of `node.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Node {
    pub radiance: [f32; 3],
    pub spread: f32,
    pub place: [f32; 3],
    pub radius: f32,
}

/// `BoxNode` of `traverse.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct BoxNode {
    pub low: [f32; 3],
    pub first: u32,
    pub high: [f32; 3],
    pub triangles: u32,
}

/// `Display` of `display_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Display {
    pub exposure: f32,
    pub count_top: f32,
    pub tone_map: u32,
    pub view_mode: u32,
    pub transparent: u32,
    pub lets_light_through: u32,
    pub samples: u32,
    pub vignette: f32,
}

/// `StaleMarks` of `keep_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct StaleMarks {
    pub materials: [u32; 2],
    pub patches: [u32; 2],
}

/// `ShadowView` of `shadow.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ShadowView {
    pub origin: [f32; 3],
    /// The distance of depth 1 in meters.
    pub depth_scale: f32,
    pub right: [f32; 3],
    /// Tangent of half the angle of view.
    pub half_width: f32,
    pub up: [f32; 3],
    pub half_height: f32,
    pub forward: [f32; 3],
    pub padding: u32,
}

/// `LocalLight` of `direct_lights.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LocalLight {
    pub position: [f32; 3],
    pub emission: u32,
    pub forward: [f32; 3],
    pub first_view: u32,
    pub intensity: [f32; 3],
    pub views_per_point: u32,
    pub half_width: [f32; 3],
    pub cos_edge: f32,
    pub half_height: [f32; 3],
    pub cos_full: f32,
    pub area: f32,
    pub grid: u32,
    pub padding: [u32; 2],
}

/// `BasisLevel` of `meshless_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct BasisLevel {
    pub cells_per_metre: f32,
    pub radius: f32,
    pub end: u32,
    pub padding: u32,
}

/// `BasisUniforms` of `meshless_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct BasisUniforms {
    pub levels: [BasisLevel; constants::MOST_BASIS_LEVELS],
    pub level_count: u32,
    pub last_slot: u32,
    pub shown_level: u32,
    pub shown_function: u32,
    pub of_objects: u32,
    pub directional_levels: u32,
}

/// `BasisFunction` of `meshless_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct BasisFunction {
    /// Padded to 16 bytes, as the normal.
    pub position: [f32; 4],
    pub normal: [f32; 4],
}

/// `LitQuad` of `wavelet_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LitQuad {
    pub corner: [f32; 3],
    pub first: u32,
    pub square_u: [f32; 3],
    pub side: u32,
    pub square_v: [f32; 3],
    pub cells: u32,
    /// Tangent, bitangent and normal, each padded to 16 bytes.
    pub frame: [[f32; 4]; 3],
}

/// `LevelUniforms` of `radiosity_level.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LevelUniforms {
    pub first: u32,
    pub end: u32,
    pub enough: f32,
}

/// `RowUniforms` of `radiosity_gather_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RowUniforms {
    pub rays: u32,
    /// In steradians.
    pub solid_angle: f32,
    pub first_slot: u32,
    pub slots: u32,
}

/// `Coefficient` of `coefficient.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Coefficient {
    /// One column per color channel, each padded to 16 bytes.
    pub vector: [[f32; 4]; 3],
}
