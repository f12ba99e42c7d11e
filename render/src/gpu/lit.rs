//! Lit cuts on the GPU: two kernels coarsen the stored cuts whenever the light changes. Twin of
//! [`LitCuts`].
//!
//! The first one counts nodes, so that the buffer is no larger than they need; the second one writes them.

use super::scene::GpuCuts;
use crate::{
    device::{
        GpuDevice, Kernel, Shaders,
        kernels::{CountedCuts, KernelProgram, LIT_COUNT, LIT_WRITE, StoredCuts, WrittenCuts},
        layout::{
            LitUniforms,
            constants::{FIELD_ENVIRONMENT, FIELD_SOURCES},
        },
        readback::read_word,
        storage, uniform,
    },
    error::BackendError,
    remedy::Remedy,
};
use lapidary_core::cut::lit::{DEFAULT_TAU, LitCuts};
use wgpu::BufferUsages as Usages;

/// Stored cuts that one workgroup coarsens; the shader's size of workgroups.
const CUTS_PER_GROUP: u32 = 64;

/// The kernels, by the tree that the cuts are over.
pub struct LitKernels {
    count: [Kernel; 2],
    write: [Kernel; 2],
}

/// Which tree the cuts are over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LitField {
    Environment,
    Sources,
}

/// Stored cuts, and the light of the tree that they are over.
#[derive(Clone, Copy)]
pub struct LitTree<'a> {
    pub field: LitField,
    pub stored: &'a GpuCuts,
    pub height: u32,
    pub nodes: &'a wgpu::Buffer,
    pub brightness: &'a wgpu::Buffer,
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

impl LitKernels {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders) -> Result<Self, BackendError> {
        let over = |program: &KernelProgram, field| Kernel::new(gpu, shaders, program, &[("FIELD", f64::from(field))]);
        let kernels = |program| Ok([over(program, FIELD_ENVIRONMENT)?, over(program, FIELD_SOURCES)?]);
        Ok(Self { count: kernels(&LIT_COUNT)?, write: kernels(&LIT_WRITE)? })
    }

    /// The stored cuts under the light of their tree, as coarse as `lit` has them; coarser where they would not fit the adapter.
    ///
    /// # Errors
    /// A lost device.
    pub fn make(&self, gpu: &GpuDevice, tree: LitTree, lit: &LitCuts) -> Result<GpuLitCuts, BackendError> {
        let [count, write] = [&self.count, &self.write].map(|kernels| &kernels[tree.field as usize]);
        let mut tau = lit.tau();
        loop {
            let work = Work::new(gpu, tree, tau);
            let bytes = u64::from(work.count(gpu, count)?) * size_of::<u32>() as u64;
            if bytes <= gpu.max_storage_bytes() {
                return work.write(gpu, write, bytes);
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
    tree: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    whole_light: wgpu::Buffer,
    offsets: wgpu::Buffer,
}

impl<'a> Work<'a> {
    fn new(gpu: &GpuDevice, tree: LitTree<'a>, tau: f32) -> Self {
        let LitTree { stored, height, nodes, brightness, .. } = tree;
        let uniforms = LitUniforms { cuts: stored.count, tau, tree_height: height };
        Self {
            stored,
            tree: StoredCuts { nodes, brightness, visibility_cuts: &stored.view }.bind(gpu),
            uniforms: uniform(gpu, "uniforms of lit cuts", bytemuck::bytes_of(&uniforms)),
            whole_light: buffer(gpu, 4 * u64::from(stored.count), Usages::empty()),
            offsets: buffer(gpu, 4 * u64::from(stored.texels), Usages::empty()),
        }
    }

    fn count(&self, gpu: &GpuDevice, kernel: &Kernel) -> Result<u32, BackendError> {
        let total = buffer(gpu, 4, Usages::COPY_SRC);
        let Self { stored, uniforms, whole_light, offsets, .. } = self;
        let cuts = CountedCuts { lit: uniforms, starts: &stored.starts, whole_light, offsets, total: &total };
        self.run(gpu, kernel, cuts.bind(gpu))?;
        read_word(gpu, &total)
    }

    fn write(self, gpu: &GpuDevice, kernel: &Kernel, bytes: u64) -> Result<GpuLitCuts, BackendError> {
        let nodes = buffer(gpu, bytes, Usages::empty());
        let Self { stored, uniforms, whole_light, offsets, .. } = &self;
        let cuts = WrittenCuts { lit: uniforms, starts: &stored.starts, whole_light, offsets, lit_nodes: &nodes };
        self.run(gpu, kernel, cuts.bind(gpu))?;
        Ok(GpuLitCuts { nodes, offsets: self.offsets })
    }

    fn run(&self, gpu: &GpuDevice, kernel: &Kernel, cuts: wgpu::BindGroup) -> Result<(), BackendError> {
        let groups = self.stored.count.div_ceil(CUTS_PER_GROUP);
        kernel.run(gpu, &[cuts, self.tree.clone()], groups).map(drop)
    }
}

/// A buffer of zeros; none can be empty.
fn buffer(gpu: &GpuDevice, bytes: u64, usage: Usages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("lit cuts"),
        size: bytes.max(4),
        usage: Usages::STORAGE | usage,
        mapped_at_creation: false,
    })
}
