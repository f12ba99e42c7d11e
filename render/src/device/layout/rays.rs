//! What kernels that trace rays read.

use bytemuck::{Pod, Zeroable};

/// `RayUniforms` of `rays_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RayUniforms {
    pub directions: u32,
    pub words: u32,
}

/// `BoundaryUniforms` of `boundaries_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct BoundaryUniforms {
    pub directions: u32,
    pub words: u32,
    pub groups: u32,
    pub groups_per_block: u32,
    pub places: u32,
    pub starts: u32,
}

/// `RayOrigin` of `ray_origin.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RayOrigin {
    pub origin: [f32; 3],
    pub height: f32,
    pub normal: [f32; 3],
    pub is_above: u32,
}

/// `FanUniforms` of `fans_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FanUniforms {
    pub directions: u32,
}

/// `Fan` of `fans_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Fan {
    /// Columns, each padded to 16 bytes.
    pub frame: [[f32; 4]; 3],
    /// Padded to 16 bytes.
    pub origin: [f32; 4],
}

/// `FanHit` of `fans_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FanHit {
    pub triangle: u32,
    pub distance: f32,
    pub barycentric: [f32; 2],
}

/// `ShadowRayUniforms` of `shadow_rays_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadowRayUniforms {
    pub rays: u32,
}

/// `ShadowRay` of `shadow_rays_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadowRay {
    pub origin: [f32; 3],
    pub reach: f32,
    pub direction: [f32; 3],
    pub padding: u32,
}
