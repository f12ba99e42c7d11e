//! The textures of one picture size: what the passes hand to each other.

use super::{device::GpuDevice, scene::extent};
use wgpu::TextureFormat as Format;

/// Formats of the passes' outputs; each pass writes at most 32 bytes per pixel, WebGPU's default limit.
pub mod format {
    use super::Format;

    pub const DEPTH: Format = Format::Depth32Float;
    pub const TRIANGLE: Format = Format::R32Uint;
    pub const GEOMETRY: Format = Format::Rgba32Uint;
    pub const FLOATS: Format = Format::Rgba32Float;
    pub const SHOWN: Format = Format::Rgba8Unorm;
}

/// A texture that passes write and read.
pub struct Target {
    pub texture: wgpu::Texture,
    pub view: wgpu::TextureView,
}

/// All targets of a picture.
pub struct Targets {
    pub size: [u32; 2],
    pub depth: Target,
    pub triangle: Target,
    pub geometry: Target,
    pub rotation: Target,
    pub color_roughness: Target,
    pub others: Target,
    /// Complete samples; read from one, written to the other, in turns.
    pub complete: [Sums; 2],
    /// A sample between its passes, in turns.
    pub partial: [Sums; 2],
    /// Lattices of a first sample, in turns: for a stride of 2 or 8, and of 4.
    pub lattices: [Sums; 2],
    pub shown: Target,
}

/// Sums over the samples.
pub struct Sums {
    /// Value of the view mode, and coverage.
    pub value: Target,
    /// Nodes of the merged cut, BRDF evaluations, wireframe coverage, surfaces.
    pub work: Target,
}

impl Targets {
    /// For pictures of `size` pixels.
    pub fn new(gpu: &GpuDevice, size: [u32; 2]) -> Self {
        let target = |label, format| target(gpu, label, format, size);
        let sums = |value, work| Sums { value: target(value, format::FLOATS), work: target(work, format::FLOATS) };
        let lattice = |stride: u32, value, work| {
            let [value, work] = [value, work]
                .map(|label| self::target(gpu, label, format::FLOATS, size.map(|side| side.div_ceil(stride))));
            Sums { value, work }
        };
        Self {
            size,
            depth: target("depth", format::DEPTH),
            triangle: target("triangle", format::TRIANGLE),
            geometry: target("geometry", format::GEOMETRY),
            rotation: target("rotation", format::FLOATS),
            color_roughness: target("color and roughness", format::FLOATS),
            others: target("other parameters", format::FLOATS),
            complete: [sums("sum 0", "work 0"), sums("sum 1", "work 1")],
            partial: [sums("partial sum 0", "partial work 0"), sums("partial sum 1", "partial work 1")],
            lattices: [lattice(2, "lattice 0", "work of lattice 0"), lattice(4, "lattice 1", "work of lattice 1")],
            shown: target("shown", format::SHOWN),
        }
    }
}

/// A texture that passes write and read.
pub fn target(gpu: &GpuDevice, label: &str, format: Format, size: [u32; 2]) -> Target {
    let usages = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: if format == format::DEPTH { usages } else { usages | wgpu::TextureUsages::COPY_SRC },
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    Target { texture, view }
}
