//! What all passes that draw are built from: layouts of bindings, and pipelines.

use super::targets::format;
use crate::device::{Binding, GpuDevice, bind_layout};
use wgpu::BindGroupLayout;

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

/// All layouts.
pub fn layouts(gpu: &GpuDevice) -> Layouts {
    use Binding::{Float, Storage, Uint, Uniform};
    let layout = |label, bindings: &[Binding]| bind_layout(gpu, label, bindings);
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
