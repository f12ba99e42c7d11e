//! A forest on the GPU and what its leaves see.

use super::{ForestTimes, GpuImplicit, light::LightBuffers};
use crate::{
    device::{
        adapter::GpuDevice,
        buffers::{storage, uniform, written},
        kernels,
        layout::{Disc, Reflected, Rider, WalkUniforms},
        readback::read_range,
    },
    error::BackendError,
    remedy::Remedy,
};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::Vec3;
use lapidary_core::implicit::{
    BinLayout, DistanceCodes, Views,
    disc_forest::DiscForest,
    forest::{self, SurfelForest},
};
use std::{collections::BTreeSet, ops::Range, time::Duration};

/// Invocations of a workgroup of kernels with one for each leaf.
pub(super) const LEAVES_PER_GROUP: u32 = 64;

/// A surfel forest on an adapter, under one pose after another.
pub struct GpuForest {
    pub(super) on: GpuImplicit,
    pub(super) buffers: Buffers,
    /// The bins of each leaf.
    pub(super) layout: BinLayout,
    /// The leaves of each object.
    leaves_of: Vec<Range<u32>>,
    pub(super) leaves: u32,
    pub(super) nodes: u32,
    walk: WalkUniforms,
    /// The objects that move while bins of all others are kept.
    dragged: Option<BTreeSet<u32>>,
    pub(super) light: LightBuffers,
    pub(super) times: ForestTimes,
}

/// What kernels of a forest read and write.
pub(super) struct Buffers {
    positions: wgpu::Buffer,
    riders: wgpu::Buffer,
    pub discs: wgpu::Buffer,
    /// First and last leaf of each node.
    pub spans: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    /// Of the cells in the frame of a leaf.
    pub directions: wgpu::Buffer,
    walk: wgpu::Buffer,
    walked: wgpu::Buffer,
    /// Nodes by leaf and cell.
    pub views: wgpu::Buffer,
    /// Keys of what does not move, made at the first drag.
    still: Option<wgpu::Buffer>,
    /// In place of what is not there to be read.
    pub nothing: wgpu::Buffer,
}

/// Which leaves look for what.
pub(super) struct Look<'a> {
    pub leaves: Range<u32>,
    /// The objects that are walked.
    pub objects: &'a dyn Fn(u32) -> bool,
    /// A layer whose bins count as well.
    pub kept: Option<&'a wgpu::Buffer>,
    /// Whether nodes are written, with holes closed, in place of keys.
    pub closes: bool,
}

impl GpuForest {
    pub(super) fn new(
        on: GpuImplicit,
        forest: &SurfelForest,
        vertices: usize,
        layout: BinLayout,
    ) -> Result<Self, BackendError> {
        let discs = forest.discs();
        assert!(!discs.discs().is_empty(), "a forest with a leaf");
        let buffers = Buffers::new(&on.gpu, forest, vertices, layout)?;
        let (leaves, nodes) = (discs.discs().len() as u32, discs.shape().nodes() as u32);
        let walk = WalkUniforms {
            root_blocks: discs.shape().root_blocks() as u32,
            limit: layout.node_limit(),
            scale: DistanceCodes::of(discs).scale(),
            turn: cos_sin(layout.turn),
            side: layout.cells.side as u32,
            ..Zeroable::zeroed()
        };
        let light = LightBuffers::new(&on.gpu, leaves, nodes);
        on.gpu.check()?;
        Ok(Self {
            buffers,
            layout,
            leaves_of: discs.shape().trees().iter().map(|tree| tree.leaves.clone()).collect(),
            leaves,
            nodes,
            walk,
            dragged: None,
            light,
            times: ForestTimes::default(),
            on,
        })
    }

    /// Takes all leaves, and the nodes above them, to vertex positions in meters.
    ///
    /// # Errors
    /// A lost device.
    pub fn update(&mut self, positions: &[Vec3]) -> Result<(), BackendError> {
        let (GpuImplicit { gpu, kernels: on }, b) = (&self.on, &self.buffers);
        gpu.queue.write_buffer(&b.positions, 0, cast_slice(positions));
        let leaves = kernels::Leaves { positions: &b.positions, riders: &b.riders, discs: &b.discs }.bind(gpu);
        let nodes = kernels::Nodes { discs: &b.discs, spans: &b.spans, blocks: &b.blocks }.bind(gpu);
        self.times.update = on.update.run(gpu, &[leaves], self.leaves.div_ceil(LEAVES_PER_GROUP))?
            + on.nodes.run(gpu, &[nodes], self.nodes)?;
        Ok(())
    }

    /// Finds what all leaves see.
    ///
    /// # Errors
    /// A lost device.
    pub fn walk(&mut self) -> Result<(), BackendError> {
        self.dragged = None;
        let look = Look { leaves: 0..self.leaves, objects: &|_| true, kept: None, closes: true };
        self.times.walk = self.look(&look, &self.buffers.views)?;
        Ok(())
    }

    /// The same after some objects have moved alone: what is seen of the others is found at the first call for these, and kept. The
    /// twin is [`lapidary_core::implicit::Drag`].
    ///
    /// # Errors
    /// A lost device.
    pub fn walk_dragged(&mut self, objects: &BTreeSet<u32>) -> Result<(), BackendError> {
        self.keep_others(objects)?;
        let still = self.buffers.still.as_ref();
        let (dragged, all): (&dyn Fn(u32) -> bool, &dyn Fn(u32) -> bool) =
            (&|other| objects.contains(&other), &|_| true);
        let (mut end, mut time) = (0, Duration::ZERO);
        let own = objects.iter().filter_map(|&object| self.leaves_of.get(object as usize));
        for own in own.filter(|own| !own.is_empty()).cloned() {
            for (leaves, objects, kept) in [(end..own.start, dragged, still), (own.clone(), all, None)] {
                time += self.look(&Look { leaves, objects, kept, closes: true }, &self.buffers.views)?;
            }
            end = own.end;
        }
        let rest = Look { leaves: end..self.leaves, objects: dragged, kept: still, closes: true };
        self.times.walk = time + self.look(&rest, &self.buffers.views)?;
        Ok(())
    }

    /// Finds what leaves see of all but some objects, unless it is known.
    fn keep_others(&mut self, objects: &BTreeSet<u32>) -> Result<(), BackendError> {
        if self.dragged.as_ref() == Some(objects) {
            return Ok(());
        }
        let still = self.buffers.still.take();
        let still = still.unwrap_or_else(|| cells_of(&self.on.gpu, "still bins", self.leaves, self.layout));
        let look =
            Look { leaves: 0..self.leaves, objects: &|other| !objects.contains(&other), kept: None, closes: false };
        self.look(&look, &still)?;
        (self.buffers.still, self.dragged) = (Some(still), Some(objects.clone()));
        Ok(())
    }

    /// One walk. Returns how long it took.
    pub(super) fn look(&self, look: &Look, into: &wgpu::Buffer) -> Result<Duration, BackendError> {
        let (GpuImplicit { gpu, kernels: on }, b) = (&self.on, &self.buffers);
        let uniforms = WalkUniforms {
            first_leaf: look.leaves.start,
            has_kept: u32::from(look.kept.is_some()),
            closes: u32::from(look.closes),
            ..self.walk
        };
        gpu.queue.write_buffer(&b.walk, 0, bytes_of(&uniforms));
        gpu.queue.write_buffer(&b.walked, 0, cast_slice(&bits(self.leaves_of.len(), look.objects)));
        let kept = look.kept.unwrap_or(&b.nothing);
        let data = kernels::Walk {
            walk: &b.walk,
            discs: &b.discs,
            blocks: &b.blocks,
            directions: &b.directions,
            walked: &b.walked,
            kept,
            seen: into,
        };
        on.walk.run(gpu, &[data.bind(gpu)], look.leaves.len() as u32)
    }

    /// What some leaves saw at the last walk.
    ///
    /// # Errors
    /// A lost device.
    pub fn views(&self, leaves: Range<u32>) -> Result<Views, BackendError> {
        let each = self.layout.cells.len();
        let cells = leaves.start as usize * each..leaves.end as usize * each;
        let nodes = if cells.is_empty() { vec![] } else { read_range(&self.on.gpu, &self.buffers.views, cells)? };
        Ok(Views::of_nodes(self.layout, leaves.start, nodes))
    }

    /// How long the last work of each kind took.
    pub fn times(&self) -> ForestTimes {
        self.times
    }

    /// Ends nodes where no integral of the cosine is larger than this, in steradians.
    #[cfg(test)]
    pub(super) fn with_limit(mut self, limit: f32) -> Self {
        self.walk.limit = limit;
        self
    }
}

impl Buffers {
    fn new(gpu: &GpuDevice, forest: &SurfelForest, vertices: usize, layout: BinLayout) -> Result<Self, BackendError> {
        let (discs, shape) = (forest.discs(), forest.discs().shape());
        let (limit, bytes) = (gpu.max_storage_bytes(), |count: usize, size: usize| count as u64 * size as u64);
        let all = bytes(discs.discs().len() * layout.cells.len(), size_of::<u32>());
        gpu.within("the bins of the surfels", "bytes", all, limit, Remedy::Cpu)?;
        gpu.within("the vertices", "bytes", bytes(vertices, size_of::<Vec3>()), limit, Remedy::FewerVertices)?;
        let spans: Vec<[u32; 2]> =
            (0..shape.nodes() as u32).map(|node| shape.span(node)).map(|s| [s.start, s.end]).collect();
        let directions: Vec<[f32; 4]> =
            (0..layout.cells.len()).map(|cell| layout.cells.direction_of(cell).extend(0.0).to_array()).collect();
        let riders: Vec<Rider> = forest.riders().iter().map(packed_rider).collect();
        Ok(Self {
            positions: storage(gpu, "posed vertices", cast_slice(&vec![Vec3::ZERO; vertices])),
            riders: storage(gpu, "riders", cast_slice(&riders)),
            discs: readable(gpu, "discs", cast_slice(&packed_discs(discs))),
            spans: storage(gpu, "spans", cast_slice(&spans)),
            blocks: readable(gpu, "blocks", cast_slice(discs.blocks())),
            directions: storage(gpu, "directions of cells", cast_slice(&directions)),
            walk: uniform(gpu, "walk", bytes_of(&WalkUniforms::zeroed())),
            walked: storage(gpu, "walked objects", cast_slice(&bits(shape.trees().len(), &|_| true))),
            views: cells_of(gpu, "views", discs.discs().len() as u32, layout),
            still: None,
            nothing: storage(gpu, "nothing", bytes_of(&Reflected::zeroed())),
        })
    }
}

/// Cosine and sine of an angle in radians.
pub(super) fn cos_sin(turn: f32) -> [f32; 2] {
    [turn.cos(), turn.sin()]
}

/// A bit for each object.
fn bits(objects: usize, is_set: &dyn Fn(u32) -> bool) -> Vec<u32> {
    let mut words = vec![0; objects.div_ceil(32)];
    (0..objects).filter(|&object| is_set(object as u32)).for_each(|object| words[object / 32] |= 1 << (object % 32));
    words
}

fn packed_rider(rider: &forest::Rider) -> Rider {
    Rider {
        corners: rider.corners,
        share: rider.share,
        barycentric: rider.place.barycentric.into(),
        is_back: u32::from(rider.back),
        padding: 0,
    }
}

pub(super) fn packed_discs(forest: &DiscForest) -> Vec<Disc> {
    let packed = |disc: &forest::nodes::Disc| Disc {
        position: disc.position.into(),
        area: disc.area,
        normal: disc.normal.into(),
        padding: 0,
    };
    forest.discs().iter().map(packed).collect()
}

/// A word for each cell of each leaf.
fn cells_of(gpu: &GpuDevice, label: &str, leaves: u32, layout: BinLayout) -> wgpu::Buffer {
    written(gpu, label, u64::from(leaves) * (layout.cells.len() * size_of::<u32>()) as u64)
}

fn readable(gpu: &GpuDevice, label: &str, contents: &[u8]) -> wgpu::Buffer {
    let buffer = written(gpu, label, contents.len() as u64);
    gpu.queue.write_buffer(&buffer, 0, contents);
    buffer
}
