//! What kernels read that compute light: of moved objects, of their vertices, and of a turned environment.

use bytemuck::{Pod, Zeroable};

/// `Disc` of `forest.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Disc {
    pub position: [f32; 3],
    pub area: f32,
    pub normal: [f32; 3],
    pub padding: u32,
}

/// `Rider` of `implicit_update_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Rider {
    pub corners: [u32; 3],
    pub share: f32,
    pub barycentric: [f32; 2],
    pub is_back: u32,
    pub padding: u32,
}

/// `WalkUniforms` of `implicit_walk_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WalkUniforms {
    pub first_leaf: u32,
    pub root_blocks: u32,
    /// In steradians.
    pub limit: f32,
    /// In 1/m².
    pub scale: f32,
    /// Cosine and sine.
    pub turn: [f32; 2],
    pub has_kept: u32,
    pub closes: u32,
    pub side: u32,
    pub padding: u32,
}

/// `CutUniforms` of `implicit_cuts.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct CutUniforms {
    /// The least squared errors by depth, with low and high word, each padded to 16 bytes.
    pub least: [[u32; 4]; 12],
    /// Cosine and sine.
    pub turn: [f32; 2],
    pub side: u32,
    pub height: u32,
    pub first_texel: u32,
    pub padding: u32,
    pub more_padding: [u32; 2],
}

/// `LeafBeside` of `leaf_beside.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafBeside {
    pub leaf: u32,
    pub weight: f32,
}

/// `CutVertex` of `cut_vertex.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct CutVertex {
    pub number: u32,
    pub first: u32,
    pub end: u32,
}

/// `LightUniforms` of `leaf_light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LightUniforms {
    /// Cosine and sine.
    pub turn: [f32; 2],
    /// One of `SENDS_...`.
    pub sends: u32,
    pub side: u32,
}

/// `LeafLighting` of `leaf_light.wgsl`. Colors are padded to 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafLighting {
    pub reflectance: [f32; 4],
    pub emitted: [f32; 4],
    pub received: [f32; 4],
}

/// `LeafIrradiance` of `leaf_light.wgsl`. Colors are padded to 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafIrradiance {
    pub of_sky: [f32; 4],
    pub direct: [f32; 4],
    pub bounced: [f32; 4],
    pub last: [f32; 4],
}

/// `GlossyLeaf` of `glossy_leaves.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GlossyLeaf {
    pub tangent: [f32; 3],
    pub leaf: u32,
    pub bitangent: [f32; 3],
    pub model: u32,
    pub normal: [f32; 3],
    pub first: u32,
}

/// `GlossUniforms` of `implicit_gloss_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GlossUniforms {
    pub eye: [f32; 3],
    pub side: u32,
    pub turn: [f32; 2],
    pub has_sent: u32,
    pub padding: u32,
}

/// `Reflected` of `reflected_light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Reflected {
    pub sky: [f32; 3],
    pub faces_eye: u32,
    pub leaves: [f32; 4],
    pub irradiance: [f32; 4],
}

/// `LeafUniforms` of `implicit_leaves_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafUniforms {
    pub weighs_albedo: u32,
    pub has_reflected: u32,
}

/// `LeafValue` of `leaf_value.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafValue {
    pub sky: [f32; 3],
    pub open: f32,
    /// Padded to 16 bytes, as the weight.
    pub others: [f32; 4],
    pub weight: [f32; 4],
}

/// `VertexUniforms` of `implicit_vertices_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct VertexUniforms {
    pub plane: u32,
    pub is_as_baked: u32,
}

/// `LitUniforms` of `lit_parts.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LitUniforms {
    pub cuts: u32,
    pub tau: f32,
    pub tree_height: u32,
}

/// `TurnedUniforms` of `turned.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct TurnedUniforms {
    pub columns: u32,
    pub shift: u32,
    pub fraction: f32,
    pub samples_per_steradian: f32,
    pub intensity: f32,
    pub leaves: u32,
    pub leaf_spread: f32,
}

/// `Means` of `turned.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Means {
    pub radiance: [f32; 3],
    pub luminance_sq: f32,
    pub weighted: [f32; 3],
    pub luminance: f32,
}

/// `MeansUniforms` of `turned_means_kernel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MeansUniforms {
    pub parents: u32,
}
