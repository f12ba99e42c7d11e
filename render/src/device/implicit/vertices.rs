//! Light of vertices on the GPU, from that of the leaves beside them.

use super::{
    GpuImplicit,
    forest::{GpuForest, LEAVES_PER_GROUP},
    gloss::GlossTable,
};
use crate::{
    device::{
        adapter::GpuDevice,
        buffers::{storage, uniform, written},
        kernels::{LitVertices, ValuedLeaves},
        layout::{LeafBeside, LeafUniforms, VertexUniforms, constants::POSED_PLANES},
        readback::read_range,
    },
    error::BackendError,
    remedy::Remedy,
};
use bytemuck::{bytes_of, cast_slice};
use std::ops::Range;

/// Vertices of a workgroup.
const VERTICES_PER_GROUP: u32 = 64;

/// Planes of the light as baked: that of the sky, and that of others.
const BAKED_PLANES: u32 = 2;

/// The leaves beside vertices with their weights, on a device.
pub struct LeavesBeside {
    pub(super) leaves: wgpu::Buffer,
    starts: wgpu::Buffer,
    /// As in the buffer.
    rows: Vec<u32>,
}

/// Colors on both sides of vertices on a device, as planes of texels: front and back of one vertex after another.
#[derive(Clone, Debug)]
pub struct VertexPlanes {
    gpu: GpuDevice,
    pub(crate) texels: wgpu::Buffer,
    vertices: u32,
}

/// What is asked of the light of vertices.
pub struct VertexRequest<'a> {
    pub beside: &'a LeavesBeside,
    /// Open share of each leaf, 0 to 1.
    pub open: &'a [f32],
    /// `VERTEX_...` of each vertex.
    pub states: &'a [u32],
    /// Whether leaves count by their albedo, as beside gloss.
    pub weighs_albedo: bool,
    /// What glossy leaves reflect, if any do so.
    pub gloss: Option<&'a GlossTable>,
    /// Light as baked, from which a pose differs; `None` for that light itself.
    pub as_baked: Option<&'a VertexPlanes>,
}

impl LeavesBeside {
    /// The leaves of the vertex, on both sides.
    pub(super) fn of(&self, vertex: u32) -> Range<u32> {
        self.rows[2 * vertex as usize]..self.rows[2 * vertex as usize + 2]
    }
}

impl VertexPlanes {
    /// Texels in a row of a texture of them.
    pub const WIDTH: u32 = 8192;

    /// Whole rows of a plane.
    pub fn rows(vertices: u32) -> u32 {
        (2 * vertices).div_ceil(Self::WIDTH).max(1)
    }

    /// Rows of one of these planes.
    pub fn own_rows(&self) -> u32 {
        Self::rows(self.vertices)
    }

    /// Whether they are on a device.
    pub fn are_on(&self, gpu: &GpuDevice) -> bool {
        self.gpu.is_same(gpu)
    }

    /// Values of a plane, front and back of one vertex after another.
    ///
    /// # Errors
    /// A lost device.
    pub fn read(&self, plane: u32) -> Result<Vec<[f32; 4]>, BackendError> {
        let first = (plane * Self::rows(self.vertices) * Self::WIDTH) as usize;
        read_range(&self.gpu, &self.texels, first..first + 2 * self.vertices as usize)
    }
}

impl GpuForest {
    /// Takes the leaves beside vertices with their weights: those of each side from one of the `starts` to the next.
    pub fn leaves_beside(&self, beside: &[(u32, f32)], starts: Vec<u32>) -> LeavesBeside {
        let leaves: Vec<_> = beside.iter().map(|&(leaf, weight)| LeafBeside { leaf, weight }).collect();
        LeavesBeside {
            leaves: storage(&self.on.gpu, "leaves beside vertices", cast_slice(&leaves)),
            starts: storage(&self.on.gpu, "leaves of each vertex", cast_slice(&starts)),
            rows: starts,
        }
    }

    /// Whether the light of so many vertices has room.
    pub fn has_room_for(&self, vertices: usize) -> bool {
        bytes_of_planes(vertices as u32, POSED_PLANES) <= self.on.gpu.max_storage_bytes()
    }

    /// Light of vertices, for which there is room, from the light of the leaves that was made last, and from what [`Self::gloss`] found
    /// if that is asked for: as baked, or what a pose changes of it.
    ///
    /// # Errors
    /// A lost device, or one without room for the leaves beside the vertices.
    pub fn at_vertices(&self, asked: &VertexRequest) -> Result<VertexPlanes, BackendError> {
        let (gpu, vertices) = (&self.on.gpu, asked.states.len() as u32);
        let (beside, limit) = (asked.beside.leaves.size(), gpu.max_storage_bytes());
        gpu.within("the leaves beside vertices", "bytes", beside, limit, Remedy::FewerVertices)?;
        self.value_leaves(asked)?;
        let planes = asked.as_baked.map_or(BAKED_PLANES, |_| POSED_PLANES);
        let texels = written(gpu, "light of vertices", bytes_of_planes(vertices, planes));
        let plane = VertexPlanes::rows(vertices) * VertexPlanes::WIDTH;
        let uniforms = VertexUniforms { plane, is_as_baked: u32::from(asked.as_baked.is_none()) };
        let lit = LitVertices {
            uniforms: &uniform(gpu, "vertices", bytes_of(&uniforms)),
            values: &self.light.values,
            beside: &asked.beside.leaves,
            starts: &asked.beside.starts,
            states: &storage(gpu, "states of vertices", cast_slice(asked.states)),
            baked: asked.as_baked.map_or(&self.buffers.nothing, |baked| &baked.texels),
            texels: &texels,
        };
        self.on.kernels.vertices.run(gpu, &[lit.bind(gpu)], vertices.div_ceil(VERTICES_PER_GROUP))?;
        Ok(VertexPlanes { gpu: gpu.clone(), texels, vertices })
    }

    /// What the leaves add to the vertices beside them.
    fn value_leaves(&self, asked: &VertexRequest) -> Result<(), BackendError> {
        let (GpuImplicit { gpu, kernels }, l) = (&self.on, &self.light);
        let uniforms = LeafUniforms {
            weighs_albedo: u32::from(asked.weighs_albedo),
            has_reflected: u32::from(asked.gloss.is_some()),
        };
        let valued = ValuedLeaves {
            uniforms: &uniform(gpu, "values of leaves", bytes_of(&uniforms)),
            lighting: &l.lighting,
            light: &l.irradiance,
            reflected: asked.gloss.map_or(&self.buffers.nothing, |table| &table.reflected),
            open: &storage(gpu, "open leaves", cast_slice(asked.open)),
            values: &l.values,
        };
        kernels.leaves.run(gpu, &[valued.bind(gpu)], self.leaves.div_ceil(LEAVES_PER_GROUP)).map(drop)
    }
}

fn bytes_of_planes(vertices: u32, planes: u32) -> u64 {
    u64::from(planes * VertexPlanes::rows(vertices)) * u64::from(VertexPlanes::WIDTH) * size_of::<[f32; 4]>() as u64
}
