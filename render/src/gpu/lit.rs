//! Lit cuts on the GPU: two kernels coarsen the cuts whenever the light changes, and those that a pose replaces. Twin of
//! [`LitCuts`](lapidary_core::cut::lit::LitCuts).
//!
//! The first one counts nodes, so that the buffer is as large as they need, with room for those of replacements; the second one writes
//! them.

use super::scene::{CutStarts, GpuCuts};
use crate::{
    device::{
        GpuDevice, Kernel, Shaders, SharedDevice,
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
use lapidary_core::cut::{lit::DEFAULT_TAU, packed::NODES_PER_TEXEL};
use std::sync::Arc;
use wgpu::BufferUsages as Usages;

/// Cuts that one workgroup coarsens; the shader's size of workgroups.
const CUTS_PER_GROUP: u32 = 64;

/// The kernels, by the tree that the cuts are over.
pub struct LitKernels {
    count: [Arc<Kernel>; 2],
    write: [Arc<Kernel>; 2],
}

/// Which tree the cuts are over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LitField {
    Environment,
    Sources,
}

/// Cuts, and the light of the tree that they are over.
#[derive(Clone, Copy)]
pub struct LitTree<'a> {
    pub field: LitField,
    pub cuts: &'a GpuCuts,
    pub height: u32,
    pub nodes: &'a wgpu::Buffer,
    pub brightness: &'a wgpu::Buffer,
}

/// Lit cuts of all vertices.
#[derive(Clone)]
pub struct GpuLitCuts {
    /// Nodes of all cuts: those of the stored ones, then those of replacements with room for as many as the texture has.
    pub nodes: wgpu::Buffer,
    /// The first node of the cut that is stored from each texel on.
    pub offsets: wgpu::Buffer,
    /// Largest share of a vertex's light that a node moves between its parts, and that which was asked for.
    tau: f32,
    asked_tau: f32,
    /// Nodes of the cuts that are stored.
    of_stored: u32,
}

impl GpuLitCuts {
    /// None, where nothing is lit.
    pub fn none(gpu: &GpuDevice) -> Self {
        let nothing = || storage(gpu, "no lit cuts", &[0; 4]);
        Self { nodes: nothing(), offsets: nothing(), tau: 0.0, asked_tau: 0.0, of_stored: 0 }
    }

    fn has_room_for(&self, cuts: &GpuCuts) -> bool {
        self.offsets.size() >= bytes_of_words(cuts.most_texels())
    }
}

impl LitKernels {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(device: &SharedDevice, shaders: &Shaders) -> Result<Self, BackendError> {
        let over =
            |program: &KernelProgram, field| device.kernel_from(shaders, program, &[("FIELD", f64::from(field))]);
        let kernels = |program| Ok([over(program, FIELD_ENVIRONMENT)?, over(program, FIELD_SOURCES)?]);
        Ok(Self { count: kernels(&LIT_COUNT)?, write: kernels(&LIT_WRITE)? })
    }

    /// The same where a pose replaced other cuts than before. What is stored stays lit, and nothing is read back, unless there is no
    /// room for so many.
    ///
    /// # Errors
    /// A lost device.
    pub fn replace(&self, gpu: &GpuDevice, tree: LitTree, lit: GpuLitCuts) -> Result<GpuLitCuts, BackendError> {
        let may_be_finer = lit.tau != lit.asked_tau && tree.cuts.others.count == 0;
        if may_be_finer || !lit.has_room_for(tree.cuts) || !self.add_others(gpu, tree, &lit)? {
            return self.make(gpu, tree, lit.asked_tau);
        }
        Ok(lit)
    }

    /// The cuts under the light of their tree, as coarse as `asked_tau` says; coarser where they would not fit the adapter. See
    /// [`LitCuts`](lapidary_core::cut::lit::LitCuts).
    ///
    /// # Errors
    /// A lost device.
    pub fn make(&self, gpu: &GpuDevice, tree: LitTree, asked_tau: f32) -> Result<GpuLitCuts, BackendError> {
        let GpuCuts { stored, stored_texels, .. } = tree.cuts;
        let (most_texels, limit) = (tree.cuts.most_texels(), gpu.max_storage_bytes());
        let offsets = buffer(gpu, bytes_of_words(most_texels), Usages::empty());
        let most_others = (most_texels - stored_texels) * NODES_PER_TEXEL as u32;
        let mut tau = asked_tau;
        loop {
            let work = Work::new(gpu, tree, tau, stored, &offsets);
            let of_stored = work.count(gpu, &self.count[tree.field as usize], 0)?.read(gpu)?;
            let bytes = bytes_of_words(of_stored);
            if bytes <= limit {
                let nodes = buffer(gpu, limit.min(bytes + bytes_of_words(most_others)), Usages::empty());
                work.write(gpu, &self.write[tree.field as usize], &nodes)?;
                let lit = GpuLitCuts { nodes, offsets: offsets.clone(), tau, asked_tau, of_stored };
                if self.add_others(gpu, tree, &lit)? {
                    return Ok(lit);
                }
            }
            if tau >= 1.0 {
                gpu.within("the lit cuts", "bytes", bytes, limit, Remedy::SmallerCuts)?;
                let all = bytes + bytes_of_words(tree.cuts.other_texels * NODES_PER_TEXEL as u32);
                gpu.within("the lit cuts", "bytes", all, limit, Remedy::SmallerCuts)?;
            }
            tau = (2.0 * tau).clamp(DEFAULT_TAU, 1.0);
        }
    }

    /// Lights the replacements. Returns whether there is room; a lit cut has no more nodes than its cut, so that they need not be counted
    /// first where there is room for all of these.
    fn add_others(&self, gpu: &GpuDevice, tree: LitTree, lit: &GpuLitCuts) -> Result<bool, BackendError> {
        let GpuCuts { others, other_texels, .. } = tree.cuts;
        if others.count == 0 {
            return Ok(true);
        }
        let work = Work::new(gpu, tree, lit.tau, others, &lit.offsets);
        let total = work.count(gpu, &self.count[tree.field as usize], lit.of_stored)?;
        let fits = |others: u32| bytes_of_words(lit.of_stored) + bytes_of_words(others) <= lit.nodes.size();
        let has_room = fits(other_texels * NODES_PER_TEXEL as u32) || fits(total.read(gpu)? - lit.of_stored);
        if has_room {
            work.write(gpu, &self.write[tree.field as usize], &lit.nodes)?;
        }
        Ok(has_room)
    }
}

/// The resources of one run.
struct Work<'a> {
    cuts: &'a CutStarts,
    tree: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    whole_light: wgpu::Buffer,
    offsets: &'a wgpu::Buffer,
}

/// The number of nodes of all cuts so far.
struct Total(wgpu::Buffer);

impl Total {
    fn read(&self, gpu: &GpuDevice) -> Result<u32, BackendError> {
        read_word(gpu, &self.0)
    }
}

impl<'a> Work<'a> {
    fn new(gpu: &GpuDevice, tree: LitTree<'a>, tau: f32, cuts: &'a CutStarts, offsets: &'a wgpu::Buffer) -> Self {
        let LitTree { cuts: all, height, nodes, brightness, .. } = tree;
        let uniforms = LitUniforms { cuts: cuts.count, tau, tree_height: height };
        Self {
            cuts,
            tree: StoredCuts { nodes, brightness, visibility_cuts: &all.view }.bind(gpu),
            uniforms: uniform(gpu, "uniforms of lit cuts", bytemuck::bytes_of(&uniforms)),
            whole_light: buffer(gpu, bytes_of_words(cuts.count), Usages::empty()),
            offsets,
        }
    }

    /// Counts nodes after `before` others.
    fn count(&self, gpu: &GpuDevice, kernel: &Kernel, before: u32) -> Result<Total, BackendError> {
        let total = buffer(gpu, bytes_of_words(1), Usages::COPY_SRC | Usages::COPY_DST);
        gpu.queue.write_buffer(&total, 0, &before.to_ne_bytes());
        let Self { cuts, uniforms, whole_light, offsets, .. } = self;
        let counted = CountedCuts { lit: uniforms, starts: &cuts.texels, whole_light, offsets, total: &total };
        self.run(gpu, kernel, counted.bind(gpu))?;
        Ok(Total(total))
    }

    fn write(&self, gpu: &GpuDevice, kernel: &Kernel, lit_nodes: &wgpu::Buffer) -> Result<(), BackendError> {
        let Self { cuts, uniforms, whole_light, offsets, .. } = self;
        let written = WrittenCuts { lit: uniforms, starts: &cuts.texels, whole_light, offsets, lit_nodes };
        self.run(gpu, kernel, written.bind(gpu))
    }

    fn run(&self, gpu: &GpuDevice, kernel: &Kernel, cuts: wgpu::BindGroup) -> Result<(), BackendError> {
        let groups = self.cuts.count.div_ceil(CUTS_PER_GROUP);
        kernel.run(gpu, &[cuts, self.tree.clone()], groups).map(drop)
    }
}

fn bytes_of_words(count: u32) -> u64 {
    u64::from(count) * size_of::<u32>() as u64
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
