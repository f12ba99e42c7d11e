//! Compiled shaders, layouts of bindings, and resources bound to them.

use super::{
    adapter::GpuDevice,
    models::ModelSet,
    shaders::{Program, ShaderSource},
};
use crate::error::BackendError;
use wgpu::{BindGroupLayout, ShaderStages as Stages};

/// Where the text of shaders comes from, and for which models it is compiled.
#[derive(Clone, Debug, Default)]
pub struct Shaders {
    pub source: ShaderSource,
    pub models: ModelSet,
    /// Whether any surface lets light through.
    pub has_veils: bool,
}

impl Shaders {
    /// The constant that tells it to passes that draw triangles.
    pub fn veils(&self) -> (&'static str, f64) {
        ("HAS_VEILS", f64::from(u8::from(self.has_veils)))
    }
}

/// The compiled text of a program.
pub fn module(gpu: &GpuDevice, shaders: &Shaders, program: &Program) -> Result<wgpu::ShaderModule, BackendError> {
    let text = shaders
        .source
        .text(program, &shaders.models)
        .map_err(|e| BackendError::Driver(format!("shader {}: {e}", program.name)))?;
    Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(program.name),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    }))
}

/// A kind of binding.
#[derive(Clone, Copy, Debug)]
pub enum Binding {
    Uniform,
    Storage,
    /// A buffer that a compute pass writes.
    Written,
    Uint,
    Float,
    DepthLayers,
}

/// Bindings 0, 1, ... of these kinds.
pub fn bind_layout(gpu: &GpuDevice, label: &str, bindings: &[Binding]) -> BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture_of =
        |sample_type, view_dimension| wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false };
    let texture = |sample_type| texture_of(sample_type, wgpu::TextureViewDimension::D2);
    let entry = |(binding, kind): (usize, &Binding)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility: match kind {
            Binding::Written => Stages::COMPUTE,
            _ => Stages::VERTEX_FRAGMENT | Stages::COMPUTE,
        },
        ty: match kind {
            Binding::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Binding::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Binding::Written => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
            Binding::Uint => texture(wgpu::TextureSampleType::Uint),
            Binding::Float => texture(wgpu::TextureSampleType::Float { filterable: false }),
            Binding::DepthLayers => texture_of(wgpu::TextureSampleType::Depth, wgpu::TextureViewDimension::D2Array),
        },
        count: None,
    };
    let entries: Vec<_> = bindings.iter().enumerate().map(entry).collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Resources at bindings 0, 1, ... of a layout.
pub fn bind(
    gpu: &GpuDevice,
    label: &str,
    layout: &BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let numbered = resources.iter().enumerate();
    let entries: Vec<_> = numbered
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
