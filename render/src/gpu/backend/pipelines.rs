//! What draws: it changes only when shaders are compiled anew.

use crate::{
    device::{
        GpuDevice, ModelSet, ShaderSource, Shaders, SharedDevice, is_emulated, layout,
        pass::{self, GpuPath},
    },
    error::BackendError,
    gpu::passes::Passes,
    measure::compare::map::magma_stops,
    remedy::Remedy,
    shade::mirrors::DEEPEST,
    stale::LightPart,
};
use std::array::from_fn;
use wgpu::util::DeviceExt;

/// A device, with the passes that are compiled on it and the buffers of their uniforms.
pub struct Pipelines {
    /// With the kernels of other work.
    pub device: SharedDevice,
    pub passes: Passes,
    /// What the passes are compiled from.
    pub shaders: Shaders,
    /// How those run that have a kernel.
    pub path: GpuPath,
    /// Whether kernels light a turned environment. Where they are emulated, the cores are faster: 16 ms in place of 170 for 32,768 samples.
    pub light_by_kernels: bool,
    pub uniforms: Uniforms,
}

/// Uniforms of what some mirrors show, by the part of its light.
pub type MirroredFrames<T> = [[T; LightPart::COUNT]; DEEPEST as usize];

/// Uniforms of the passes of a picture.
pub struct Uniforms {
    pub frame: wgpu::Buffer,
    /// For the points that mirrors show.
    pub mirrored: MirroredFrames<wgpu::Buffer>,
    pub display: wgpu::Buffer,
    pub magma: wgpu::Buffer,
}

impl Pipelines {
    /// Passes that are compiled when a picture needs them. Shaders of a folder are being worked on: errors in them are told at once.
    ///
    /// # Errors
    /// A shader that cannot be read, or does not compile if it is one of a folder.
    pub fn new(device: SharedDevice, source: &ShaderSource, path: GpuPath) -> Result<Self, BackendError> {
        let shaders = Shaders { source: source.clone(), ..Default::default() };
        let passes = Passes::new(&device, &shaders, path)?;
        if source.is_edited() {
            passes.compile()?;
        }
        let light_by_kernels = !device.is_emulated();
        Ok(Self { uniforms: Uniforms::new(&device.gpu), device, passes, shaders, path, light_by_kernels })
    }

    /// The device itself.
    pub fn gpu(&self) -> &GpuDevice {
        &self.device.gpu
    }

    /// Takes the passes for other models, whose texts come from where they came from.
    ///
    /// # Errors
    /// A shader that cannot be read, or does not compile if it is one of a folder. The previous ones stay then.
    pub fn specialize(&mut self, models: ModelSet, has_veils: bool) -> Result<(), BackendError> {
        let shaders = Shaders { models, has_veils, source: self.shaders.source.clone() };
        self.passes = self.with(&shaders, self.path)?;
        self.shaders = shaders;
        Ok(())
    }

    /// Reads the shaders again, for a path.
    ///
    /// # Errors
    /// As [`Self::new`]. The previous ones stay then.
    pub fn reload(&mut self, path: GpuPath) -> Result<(), BackendError> {
        self.passes = self.with(&self.shaders, path)?;
        self.path = path;
        Ok(())
    }

    /// Passes from other shaders or for another path, in the same variants.
    fn with(&self, shaders: &Shaders, path: GpuPath) -> Result<Passes, BackendError> {
        let mut passes = Passes::new(&self.device, shaders, path)?;
        passes.take_variants(&self.passes, shaders.source.is_edited());
        if shaders.source.is_edited() {
            passes.compile()?;
        }
        Ok(passes)
    }

    /// Compiles on other threads what sketches need, and then all others, so that no first lamp or orbit waits. An emulated adapter has
    /// better use for the cores.
    pub fn compile_soon(&self) {
        let others = self.passes.all().filter(|_| !is_emulated(&self.gpu().info));
        pass::compile_soon(self.passes.of_sketches().chain(others).cloned());
    }

    /// Does some work, and waits for it.
    ///
    /// # Errors
    /// A lost device.
    pub fn submit(&self, encode: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<(), BackendError> {
        let mut encoder = self.gpu().device.create_command_encoder(&Default::default());
        encode(&mut encoder);
        self.gpu().queue.submit([encoder.finish()]);
        self.gpu().wait()
    }

    /// An error for a picture that the adapter has no room for.
    pub fn check_size(&self, size: [u32; 2]) -> Result<(), BackendError> {
        let gpu = self.gpu();
        let limit = u64::from(gpu.limits.max_texture_dimension_2d);
        let longest = u64::from(size[0].max(size[1]));
        gpu.within("the sides of the picture", "pixels", longest, limit, Remedy::SmallerPicture)?;
        let bytes = u64::from(size[0].next_multiple_of(256)) * u64::from(size[1]) * 16;
        gpu.within("the pixels of the picture", "bytes", bytes, gpu.limits.max_buffer_size, Remedy::SmallerPicture)
    }
}

impl Uniforms {
    fn new(gpu: &GpuDevice) -> Self {
        let uniform = |label, size: usize| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let magma = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("magma"),
            contents: bytemuck::cast_slice(&magma_stops().map(|c| c.extend(1.0).to_array())),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let frame = |label| uniform(label, size_of::<layout::FrameUniforms>());
        Self {
            frame: frame("frame"),
            mirrored: from_fn(|_| from_fn(|_| frame("mirrored frame"))),
            display: uniform("display", size_of::<layout::Display>()),
            magma,
        }
    }
}
