//! What glossy leaves reflect toward the eye, on the GPU.

use super::{
    GpuImplicit,
    forest::{GpuForest, cos_sin},
};
use crate::{
    device::{
        buffers::{storage, uniform, written},
        kernel::Kernel,
        kernels::Glossy,
        layout::{GlossUniforms, GlossyLeaf, Reflected},
        tables::tables,
    },
    error::BackendError,
};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::{Mat3, Vec3, Vec4};
use lapidary_core::brdf::BrdfModel;
use std::sync::Arc;

/// The BRDF of a glossy leaf.
#[derive(Clone, Copy, Debug)]
pub struct LeafLobes {
    /// Its number among all leaves.
    pub leaf: u32,
    pub model: BrdfModel,
    /// The value of its first parameter, among all values.
    pub first: u32,
}

/// Glossy leaves of a forest on an adapter, with the values of their materials.
pub struct GlossTable {
    kernel: Arc<Kernel>,
    leaves: Vec<LeafLobes>,
    uniforms: wgpu::Buffer,
    tables: wgpu::Buffer,
    materials: wgpu::Buffer,
    values: wgpu::Buffer,
    sent: wgpu::Buffer,
    /// Of all leaves.
    pub(super) reflected: wgpu::Buffer,
}

/// What is reflected where.
pub struct GlossRequest<'a> {
    /// Shading frame of each glossy leaf: tangent, bitangent and normal as columns.
    pub frames: &'a [Mat3],
    /// Position of the eye in meters.
    pub eye: Vec3,
    /// Whether they reflect the light of other leaves, too.
    pub has_sent: bool,
}

impl GpuForest {
    /// Takes glossy leaves, one or more, and the values of the parameters of their models. `None` if there is no room for them.
    pub fn gloss_table(&self, kernel: Arc<Kernel>, leaves: Vec<LeafLobes>, values: &[Vec4]) -> Option<GlossTable> {
        let gpu = &self.on.gpu;
        let bytes = |count: usize, size: usize| (count * size) as u64;
        let of_nodes = bytes(self.nodes as usize, size_of::<Vec4>());
        let of_leaves = bytes(self.leaves as usize, size_of::<Reflected>());
        if size_of_val(values) as u64 > gpu.max_storage_bytes() || of_leaves > gpu.max_storage_bytes() {
            return None;
        }
        Some(GlossTable {
            kernel,
            uniforms: uniform(gpu, "gloss of leaves", bytes_of(&GlossUniforms::zeroed())),
            tables: tables(gpu),
            materials: written(gpu, "glossy leaves", bytes(leaves.len(), size_of::<GlossyLeaf>())),
            values: storage(gpu, "values of glossy leaves", cast_slice(values)),
            sent: written(gpu, "light that nodes send", of_nodes),
            reflected: written(gpu, "light that leaves reflect", of_leaves),
            leaves,
        })
    }

    /// Finds what the leaves of a table reflect toward the eye, by what they saw at the last walk, of the light that was made last.
    ///
    /// # Errors
    /// A lost device.
    pub fn gloss(&self, table: &GlossTable, asked: &GlossRequest) -> Result<(), BackendError> {
        let (GpuImplicit { gpu, .. }, b) = (&self.on, &self.buffers);
        let uniforms = GlossUniforms {
            eye: asked.eye.into(),
            side: self.layout.cells.side as u32,
            turn: cos_sin(self.layout.turn),
            has_sent: u32::from(asked.has_sent),
            padding: 0,
        };
        gpu.queue.write_buffer(&table.uniforms, 0, bytes_of(&uniforms));
        let leaves: Vec<GlossyLeaf> = table.leaves.iter().zip(asked.frames).map(packed).collect();
        gpu.queue.write_buffer(&table.materials, 0, cast_slice(&leaves));
        if asked.has_sent {
            self.pull_all(&table.sent)?;
        }
        let glossy = Glossy {
            uniforms: &table.uniforms,
            tables: &table.tables,
            materials: &table.materials,
            values: &table.values,
            discs: &b.discs,
            views: &b.views,
            directions: &b.directions,
            sent: &table.sent,
            sky: &self.light.sky,
            reflected: &table.reflected,
        };
        table.kernel.run(gpu, &[glossy.bind(gpu)], leaves.len() as u32).map(drop)
    }
}

fn packed((of, frame): (&LeafLobes, &Mat3)) -> GlossyLeaf {
    GlossyLeaf {
        tangent: frame.x_axis.into(),
        leaf: of.leaf,
        bitangent: frame.y_axis.into(),
        model: of.model as u32,
        normal: frame.z_axis.into(),
        first: of.first,
    }
}
