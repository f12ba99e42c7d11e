//! The textures of one picture size: what the passes hand to each other.

use super::scene::extent;
use crate::{device::GpuDevice, shade::mirrors::DEEPEST, stale::LightPart};
use wgpu::TextureFormat as Format;

/// Formats of the passes' outputs; each pass writes at most 32 bytes per pixel, WebGPU's default limit.
pub mod format {
    use super::Format;

    pub const DEPTH: Format = Format::Depth32Float;
    pub const TRIANGLE: Format = Format::R32Uint;
    pub const GEOMETRY: Format = Format::Rgba32Uint;
    pub const BITS: Format = Format::Rgba32Uint;
    pub const FLOATS: Format = Format::Rgba32Float;
    pub const MARKS: Format = Format::Rgba32Uint;
    /// Values and work of a part of the light.
    pub const SUMS: [Format; 2] = [FLOATS, Format::Rgba32Uint];
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
    /// What the pixels show; read from one, written to the other, in turns.
    pub marks: [Target; 2],
    /// By [`LightPart`], as far as the light has them; read from one, written to the other, in turns.
    pub parts: [Option<[Sums; 2]>; LightPart::COUNT],
    /// Lattices of a first sample, by [`LightPart`]: for strides of 2 and 8, and of 4.
    pub lattices: [Option<[Sums; 2]>; LightPart::COUNT],
    /// A texel of zeros, in place of parts that the light does not have.
    pub nothing: Sums,
    /// Rays to suns that meet nothing, if suns shine.
    pub suns_seen: Option<Target>,
    /// Of a picture whose mirrors show the scene.
    pub mirrored: Option<Mirrored>,
    pub shown: Target,
}

/// What mirrors show.
pub struct Mirrored {
    /// Of one mirror, and of a mirror in it.
    pub points: [MirroredPoints; DEEPEST as usize],
    /// Light along the rays of wider lobes.
    pub second: Target,
}

/// Rays of mirrors, and for the surfaces that these meet what the others are for those that the camera sees.
pub struct MirroredPoints {
    pub rays: Target,
    pub weights: Target,
    pub geometry: Target,
    pub rotation: Target,
    pub color_roughness: Target,
    /// Light of all kinds; read from one, written to the other, part by part.
    pub sums: [Sums; 2],
}

impl Mirrored {
    fn new(gpu: &GpuDevice, size: [u32; 2]) -> Self {
        let points = || MirroredPoints::new(gpu, size);
        Self {
            points: std::array::from_fn(|_| points()),
            second: target(gpu, "light of second rays", format::FLOATS, size),
        }
    }
}

impl MirroredPoints {
    fn new(gpu: &GpuDevice, size: [u32; 2]) -> Self {
        let target = |label, format| target(gpu, label, format, size);
        Self {
            rays: target("mirror rays", format::FLOATS),
            weights: target("mirror weights", format::FLOATS),
            geometry: target("mirrored geometry", format::GEOMETRY),
            rotation: target("mirrored rotation", format::FLOATS),
            color_roughness: target("mirrored color and roughness", format::FLOATS),
            sums: [0, 1].map(|_| Sums::new(gpu, size)),
        }
    }
}

/// Sums over the samples of one part of the light, see `sums.wgsl`.
pub struct Sums {
    /// Values, and coverage by lines.
    pub value: Target,
    /// Work and numbers of samples.
    pub work: Target,
}

impl Sums {
    /// Of a picture or a lattice of `size`.
    pub fn new(gpu: &GpuDevice, size: [u32; 2]) -> Self {
        let [value, work] = format::SUMS;
        Self { value: target(gpu, "sums", value, size), work: target(gpu, "work", work, size) }
    }
}

impl Targets {
    /// For pictures of `size` pixels.
    pub fn new(gpu: &GpuDevice, size: [u32; 2]) -> Self {
        let target = |label, format| target(gpu, label, format, size);
        Self {
            size,
            depth: target("depth", format::DEPTH),
            triangle: target("triangle", format::TRIANGLE),
            geometry: target("geometry", format::GEOMETRY),
            rotation: target("rotation", format::FLOATS),
            color_roughness: target("color and roughness", format::FLOATS),
            marks: [0, 1].map(|_| target("marks", format::MARKS)),
            parts: Default::default(),
            lattices: Default::default(),
            nothing: Sums::new(gpu, [1, 1]),
            suns_seen: None,
            mirrored: None,
            shown: target("shown", format::SHOWN),
        }
    }

    /// Makes room for the parts of a light, and for rays to suns if these shine; frees the others.
    pub fn set_parts(&mut self, gpu: &GpuDevice, parts: [bool; LightPart::COUNT], suns: bool) {
        let size = self.size;
        let seen = || target(gpu, "suns seen", format::BITS, size);
        self.suns_seen = suns.then(|| self.suns_seen.take().unwrap_or_else(seen));
        for (sums, shown) in self.parts.iter_mut().zip(parts) {
            *sums = if shown { sums.take().or_else(|| Some([0, 1].map(|_| Sums::new(gpu, size)))) } else { None };
        }
        let mirrors = parts[LightPart::Mirrors as usize];
        self.mirrored = mirrors.then(|| self.mirrored.take().unwrap_or_else(|| Mirrored::new(gpu, size)));
        let lattice = |stride: u32| Sums::new(gpu, size.map(|side| side.div_ceil(stride)));
        for (sums, shown) in self.lattices.iter_mut().zip(parts) {
            *sums = if shown { sums.take().or_else(|| Some([2, 4].map(lattice))) } else { None };
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
        usage: match format {
            format::DEPTH => usages,
            format::FLOATS | format::GEOMETRY => {
                usages | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::STORAGE_BINDING
            }
            _ => usages | wgpu::TextureUsages::COPY_SRC,
        },
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    Target { texture, view }
}
