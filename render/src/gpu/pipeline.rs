//! What all passes are built from: compiled shaders, layouts of bindings, pipelines, and resources bound to them.

use super::{
    device::GpuDevice,
    models::ModelSet,
    shaders::{Program, ShaderSource},
    targets::format,
};
use crate::backend::BackendError;
use wgpu::{BindGroupLayout, ShaderStages as Stages};

/// Bind group layouts by what they hold.
pub struct Layouts {
    pub frame: BindGroupLayout,
    /// The mesh and its materials.
    pub scene: BindGroupLayout,
    pub light: BindGroupLayout,
    /// One texture of unsigned integers.
    pub ids: BindGroupLayout,
    pub parameters: BindGroupLayout,
    pub merge: BindGroupLayout,
    /// The other passes that add to sums.
    pub addition: BindGroupLayout,
    pub display: BindGroupLayout,
    /// The sums of a lattice, and what the last picture tells.
    pub lattice: BindGroupLayout,
    /// The sums of another part of the light, and what the pixels show.
    pub added: BindGroupLayout,
    /// A part of the light in the last picture.
    pub past: BindGroupLayout,
    pub patches: BindGroupLayout,
    pub marks: BindGroupLayout,
    pub keep: BindGroupLayout,
}

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

/// What differs between pipelines.
pub struct Pipeline<'a> {
    pub module: wgpu::ShaderModule,
    pub label: &'static str,
    pub layouts: &'a [&'a BindGroupLayout],
    pub targets: &'a [wgpu::TextureFormat],
    pub constants: &'a [(&'a str, f64)],
    pub depth: bool,
}

impl<'a> Pipeline<'a> {
    pub fn new(module: wgpu::ShaderModule, label: &'static str) -> Self {
        Self { module, label, layouts: &[], targets: &[], constants: &[], depth: false }
    }

    pub fn build(&self, gpu: &GpuDevice) -> wgpu::RenderPipeline {
        let layouts: Vec<_> = self.layouts.iter().map(|&l| Some(l)).collect();
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let target = |&format: &wgpu::TextureFormat| {
            Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        };
        let targets: Vec<_> = self.targets.iter().map(target).collect();
        let options = wgpu::PipelineCompilationOptions { constants: self.constants, ..Default::default() };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            // Depth grows toward the eye and is 0 at infinity: floats are finest near 0.
            depth_stencil: self.depth.then(|| wgpu::DepthStencilState {
                format: format::DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("fragment"),
                compilation_options: options,
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A kind of binding.
#[derive(Clone, Copy)]
pub enum Binding {
    Uniform,
    Storage,
    /// A buffer that a compute pass writes.
    Written,
    Uint,
    Float,
    DepthLayers,
}

/// All layouts.
pub fn layouts(gpu: &GpuDevice) -> Layouts {
    use Binding::{Float, Storage, Uint, Uniform};
    let layout = |label, bindings: &[Binding]| layout(gpu, label, bindings);
    Layouts {
        frame: layout("frame", &[Uniform]),
        scene: layout("scene", &[Storage, Storage, Storage, Uint, Uniform, Storage, Float]),
        light: layout("light", &[Storage, Storage, Uint, Uint, Storage, Storage]),
        ids: layout("ids", &[Uint]),
        parameters: layout("parameters", &[Uint, Float]),
        merge: layout("merge", &[Uint, Float, Float, Float, Uint, Float, Float]),
        addition: layout("addition", &[Uint, Float, Float, Float, Uint]),
        display: layout("display", &[Uniform, Uniform, Float, Uint, Float, Uint, Float, Uint, Float, Uint]),
        lattice: layout("lattice", &[Float, Uint, Float]),
        added: layout("added", &[Float, Uint, Uint]),
        past: layout("past", &[Uniform, Float, Uint]),
        patches: layout("patches", &[Storage]),
        marks: layout("marks", &[Uint, Uint]),
        keep: layout("keep", &[Uniform, Uint, Float, Uint, Float]),
    }
}

/// Bindings 0, 1, ... of these kinds.
pub fn layout(gpu: &GpuDevice, label: &str, bindings: &[Binding]) -> BindGroupLayout {
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
