//! Pipelines of the passes that draw, built from their entries.

use super::{entries::Entry, targets::format};
use crate::{
    device::{GpuDevice, Shaders, module_of},
    error::BackendError,
};
use std::sync::{Arc, OnceLock};

/// The text of a pass, of which variants are built.
pub struct Text {
    entry: &'static Entry,
    text: String,
    gpu: GpuDevice,
    module: OnceLock<wgpu::ShaderModule>,
}

/// One variant of a pass, which is compiled at its first use: most pictures use few of the passes.
#[derive(Clone)]
pub struct Pass {
    pub label: &'static str,
    variant: Arc<Variant>,
}

struct Variant {
    text: Arc<Text>,
    /// Of the constants of its entry.
    values: Vec<f64>,
    pipeline: OnceLock<wgpu::RenderPipeline>,
}

impl Text {
    /// The text of a pass.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders, entry: &'static Entry) -> Result<Arc<Self>, BackendError> {
        let text = shaders.text(&entry.program)?;
        Ok(Self { entry, text, gpu: gpu.clone(), module: OnceLock::new() }.into())
    }

    /// The variant with these values of the constants of its entry.
    pub fn variant(self: &Arc<Self>, values: &[f64]) -> Pass {
        let label = self.entry.program.name;
        debug_assert_eq!(self.entry.constants.len(), values.len(), "{label}");
        let variant = Variant { text: self.clone(), values: values.to_vec(), pipeline: OnceLock::new() };
        Pass { label, variant: variant.into() }
    }

    fn module(&self) -> &wgpu::ShaderModule {
        self.module.get_or_init(|| module_of(&self.gpu, self.entry.program.name, &self.text))
    }
}

impl Pass {
    /// Its pipeline; the device tells of a shader that does not compile.
    pub fn pipeline(&self) -> &wgpu::RenderPipeline {
        self.variant.pipeline.get_or_init(|| self.variant.build())
    }
}

impl Variant {
    fn build(&self) -> wgpu::RenderPipeline {
        let (gpu, module) = (&self.text.gpu, self.text.module());
        let Entry { program, groups, targets, has_depth, constants } = self.text.entry;
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
        let constants: Vec<_> = constants.iter().copied().zip(self.values.iter().copied()).collect();
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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
        })
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
