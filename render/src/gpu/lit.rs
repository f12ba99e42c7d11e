//! Lit cuts on the GPU: a compute pass coarsens the stored cuts whenever the light changes. Twin of
//! [`LitCuts`](lapidary_core::cut::lit::LitCuts).
//!
//! A first pass counts nodes, so that the buffer is no larger than they need; a second one writes them.

use super::scene::GpuCuts;
use crate::{
    device::{
        Binding, GpuDevice, Shaders, bind, bind_layout, layout, module, readback::read_word, shaders::LIT, storage,
        uniform,
    },
    error::BackendError,
    remedy::Remedy,
};
use bytemuck::Zeroable;
use lapidary_core::cut::lit::{DEFAULT_TAU, LitCuts};
use wgpu::{BindGroupLayout, BindingResource::TextureView as View, BufferUsages as Usages};

/// Stored cuts that one workgroup coarsens; the shader's size of workgroups.
const CUTS_PER_GROUP: u32 = 64;

/// The pipelines, with what they read.
pub struct LitPass {
    frame: BindGroupLayout,
    light: BindGroupLayout,
    cuts: BindGroupLayout,
    count: [wgpu::ComputePipeline; 2],
    write: [wgpu::ComputePipeline; 2],
}

/// Which tree the cuts are over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LitField {
    Environment,
    Sources,
}

/// Lit cuts of all vertices.
#[derive(Clone)]
pub struct GpuLitCuts {
    /// Nodes of all cuts.
    pub nodes: wgpu::Buffer,
    /// The first node of the cut that is stored from each texel on.
    pub offsets: wgpu::Buffer,
}

impl GpuLitCuts {
    /// None, where nothing is lit.
    pub fn none(gpu: &GpuDevice) -> Self {
        Self { nodes: storage(gpu, "no lit cuts", &[0; 4]), offsets: storage(gpu, "no lit cuts", &[0; 4]) }
    }
}

impl LitPass {
    /// Builds the pipelines.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders) -> Result<Self, BackendError> {
        use Binding::{Storage, Uint, Uniform, Written};
        let frame = bind_layout(gpu, "frame of lit cuts", &[Uniform]);
        let nothing = bind_layout(gpu, "nothing", &[]);
        let light = bind_layout(gpu, "light of lit cuts", &[Storage, Storage, Uint]);
        let cuts = bind_layout(gpu, "lit cuts", &[Uniform, Storage, Written, Written, Written, Written]);
        let module = module(gpu, shaders, &LIT)?;
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("lit cuts"),
            bind_group_layouts: &[Some(&frame), Some(&nothing), Some(&light), Some(&cuts)],
            immediate_size: 0,
        });
        let fields = [layout::constants::FIELD_ENVIRONMENT, layout::constants::FIELD_SOURCES];
        let pipelines = |entry_point| {
            fields.map(|field| {
                gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some("lit cuts"),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("FIELD", f64::from(field))],
                        ..Default::default()
                    },
                    cache: None,
                })
            })
        };
        let (count, write) = (pipelines("count"), pipelines("write"));
        Ok(Self { frame, light, cuts, count, write })
    }

    /// The cuts of `stored` under the light of a tree of `height` with `nodes`, as coarse as `lit` has them; coarser where
    /// they would not fit the adapter.
    ///
    /// # Errors
    /// A lost device.
    pub fn make(
        &self,
        gpu: &GpuDevice,
        field: LitField,
        (stored, height): (&GpuCuts, u32),
        nodes: &wgpu::Buffer,
        lit: &LitCuts,
    ) -> Result<GpuLitCuts, BackendError> {
        let mut tau = lit.tau();
        loop {
            let work = Work::new(self, gpu, (stored, height), nodes, tau);
            let total = work.count(gpu, &self.count[field as usize])?;
            let bytes = u64::from(total) * size_of::<u32>() as u64;
            if bytes <= gpu.max_storage_bytes() {
                return work.write(self, gpu, &self.write[field as usize], bytes);
            }
            if tau >= 1.0 {
                gpu.within("the lit cuts", "bytes", bytes, gpu.max_storage_bytes(), Remedy::SmallerCuts)?;
            }
            tau = (2.0 * tau).clamp(DEFAULT_TAU, 1.0);
        }
    }
}

/// The resources of one run.
struct Work<'a> {
    stored: &'a GpuCuts,
    frame: wgpu::BindGroup,
    light: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    offsets: wgpu::Buffer,
    total: wgpu::Buffer,
    whole_light: wgpu::Buffer,
    cuts: wgpu::BindGroup,
}

impl<'a> Work<'a> {
    fn new(
        pass: &LitPass,
        gpu: &GpuDevice,
        (stored, height): (&'a GpuCuts, u32),
        nodes: &wgpu::Buffer,
        tau: f32,
    ) -> Self {
        let heights = layout::FrameUniforms {
            tree_height: height,
            source_tree_height: height,
            ..layout::FrameUniforms::zeroed()
        };
        let frame = uniform(gpu, "heights of lit cuts", bytemuck::bytes_of(&heights));
        let lit = layout::LitUniforms { cuts: stored.count, tau };
        let buffer = |words: u32, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("lit cuts"),
                size: u64::from(words) * 4,
                usage: Usages::STORAGE | usage,
                mapped_at_creation: false,
            })
        };
        let offsets = buffer(stored.texels.max(1), Usages::empty());
        let total = buffer(1, Usages::COPY_SRC);
        let whole_light = buffer(stored.count.max(1), Usages::empty());
        let uniforms = uniform(gpu, "uniforms of lit cuts", bytemuck::bytes_of(&lit));
        // Nothing is written while nodes are counted.
        let unwritten = buffer(1, Usages::empty());
        let light = [nodes.as_entire_binding(), nodes.as_entire_binding(), View(&stored.view)];
        Self {
            stored,
            frame: bind(gpu, "frame of lit cuts", &pass.frame, &[frame.as_entire_binding()]),
            light: bind(gpu, "light of lit cuts", &pass.light, &light),
            cuts: bind_cuts(pass, gpu, stored, [&uniforms, &offsets, &unwritten, &total, &whole_light]),
            uniforms,
            offsets,
            total,
            whole_light,
        }
    }

    fn count(&self, gpu: &GpuDevice, pipeline: &wgpu::ComputePipeline) -> Result<u32, BackendError> {
        self.run(gpu, pipeline, &self.cuts);
        read_word(gpu, &self.total)
    }

    fn write(
        self,
        pass: &LitPass,
        gpu: &GpuDevice,
        pipeline: &wgpu::ComputePipeline,
        bytes: u64,
    ) -> Result<GpuLitCuts, BackendError> {
        let nodes = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lit cuts"),
            size: bytes.max(4),
            usage: Usages::STORAGE,
            mapped_at_creation: false,
        });
        let buffers = [&self.uniforms, &self.offsets, &nodes, &self.total, &self.whole_light];
        self.run(gpu, pipeline, &bind_cuts(pass, gpu, self.stored, buffers));
        gpu.check()?;
        Ok(GpuLitCuts { nodes, offsets: self.offsets })
    }

    fn run(&self, gpu: &GpuDevice, pipeline: &wgpu::ComputePipeline, cuts: &wgpu::BindGroup) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.frame, &[]);
            pass.set_bind_group(2, &self.light, &[]);
            pass.set_bind_group(3, cuts, &[]);
            let groups = self.stored.count.div_ceil(CUTS_PER_GROUP);
            let columns = groups.min(gpu.limits.max_compute_workgroups_per_dimension);
            pass.dispatch_workgroups(columns, groups.div_ceil(columns.max(1)), 1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}

fn bind_cuts(
    pass: &LitPass,
    gpu: &GpuDevice,
    stored: &GpuCuts,
    [uniforms, offsets, nodes, total, whole_light]: [&wgpu::Buffer; 5],
) -> wgpu::BindGroup {
    let buffers = [uniforms, &stored.starts, offsets, nodes, total, whole_light].map(|b| b.as_entire_binding());
    bind(gpu, "lit cuts", &pass.cuts, &buffers)
}
