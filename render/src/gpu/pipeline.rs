//! Pipelines of the passes that draw, built from their entries.

use super::{entries::Entry, targets::format};
use crate::{
    device::{GpuDevice, Shaders, module},
    error::BackendError,
};

/// A pass with the text that it was compiled from, of which variants are built.
pub struct Compiled {
    entry: &'static Entry,
    module: wgpu::ShaderModule,
}

/// One variant of a pass.
#[derive(Clone)]
pub struct Pass {
    pub label: &'static str,
    pub pipeline: wgpu::RenderPipeline,
}

impl Compiled {
    /// Compiles the text of a pass.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders, entry: &'static Entry) -> Result<Self, BackendError> {
        Ok(Self { entry, module: module(gpu, shaders, &entry.program)? })
    }

    /// The variant with these values of the constants of its entry.
    pub fn variant(&self, gpu: &GpuDevice, values: &[f64]) -> Pass {
        let Self { entry: Entry { program, groups, targets, has_depth, constants }, module } = self;
        debug_assert_eq!(constants.len(), values.len(), "{}", program.name);
        let label = Some(program.name);
        let groups: Vec<_> = groups.iter().map(|group| Some(group.on(gpu))).collect();
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &groups.iter().map(Option::as_ref).collect::<Vec<_>>(),
            immediate_size: 0,
        });
        let target = |&format: &wgpu::TextureFormat| {
            Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        };
        let constants: Vec<_> = constants.iter().copied().zip(values.iter().copied()).collect();
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: has_depth.then(depth),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                targets: &targets.iter().map(target).collect::<Vec<_>>(),
            }),
            multiview_mask: None,
            cache: None,
        });
        Pass { label: program.name, pipeline }
    }
}

/// Depth grows toward the eye and is 0 at infinity: floats are finest near 0.
fn depth() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: format::DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    }
}
