//! Pipelines of the passes that draw, built from their entries.

use super::{entries::Entry, targets::format};
use crate::{
    device::{GpuDevice, Shaders, module_of, output::Output},
    error::BackendError,
};
use serde::{Deserialize, Serialize};
use std::{
    sync::{Arc, OnceLock},
    time::{Duration, Instant},
};

/// How passes run that have two entry points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GpuPath {
    /// A fragment for each pixel.
    #[default]
    Fragment,
    /// An invocation of a kernel for each.
    Compute,
}

/// The text of a pass, of which variants are built.
pub struct Text {
    entry: &'static Entry,
    text: String,
    gpu: GpuDevice,
    path: GpuPath,
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
    /// With the time that it took to compile.
    pipeline: OnceLock<(Pipeline, Duration)>,
}

/// How a pass runs.
pub enum Pipeline {
    Fragments(wgpu::RenderPipeline),
    /// A kernel, and its group 0.
    Kernel(wgpu::ComputePipeline, Output),
}

impl Text {
    /// The text of a pass, which is a kernel on that path if it can be.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(
        gpu: &GpuDevice,
        shaders: &Shaders,
        path: GpuPath,
        entry: &'static Entry,
    ) -> Result<Arc<Self>, BackendError> {
        let text = shaders.text(&entry.program)?;
        Ok(Self { entry, text, gpu: gpu.clone(), path, module: OnceLock::new() }.into())
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
    pub fn pipeline(&self) -> &Pipeline {
        let (pipeline, _) = self.variant.pipeline.get_or_init(|| {
            let start = Instant::now();
            (self.variant.build(), start.elapsed())
        });
        pipeline
    }

    /// What it took to compile, if it is.
    pub fn compile_time(&self) -> Option<Duration> {
        self.variant.pipeline.get().map(|(_, time)| *time)
    }

    /// The device that it is compiled on.
    pub fn gpu(&self) -> &GpuDevice {
        &self.variant.text.gpu
    }
}

impl Variant {
    fn build(&self) -> Pipeline {
        let Text { entry, path, .. } = &*self.text;
        let constants: Vec<_> = entry.constants.iter().copied().zip(self.values.iter().copied()).collect();
        let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        match entry.program.output {
            Some(output) if *path == GpuPath::Compute => self.kernel(output, options),
            _ => Pipeline::Fragments(self.fragments(options)),
        }
    }

    fn layout(&self, groups: &[wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
        let groups: Vec<_> = groups.iter().map(Some).collect();
        self.text.gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.text.entry.program.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        })
    }

    fn kernel(&self, output: Output, compilation_options: wgpu::PipelineCompilationOptions) -> Pipeline {
        let (Text { gpu, entry, .. }, module) = (&*self.text, self.text.module());
        let groups: Vec<_> = [&output].into_iter().chain(&entry.groups[1..]).map(|group| group.on(gpu)).collect();
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry.program.name),
            layout: Some(&self.layout(&groups)),
            module,
            entry_point: Some("compute"),
            compilation_options,
            cache: None,
        });
        Pipeline::Kernel(pipeline, output)
    }

    fn fragments(&self, compilation_options: wgpu::PipelineCompilationOptions) -> wgpu::RenderPipeline {
        let (Text { gpu, entry, .. }, module) = (&*self.text, self.text.module());
        let groups: Vec<_> = entry.groups.iter().map(|group| group.on(gpu)).collect();
        let target = |format: wgpu::TextureFormat| {
            Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry.program.name),
            layout: Some(&self.layout(&groups)),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: entry.has_depth.then(depth),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fragment"),
                compilation_options,
                targets: &entry.formats().into_iter().map(target).collect::<Vec<_>>(),
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
