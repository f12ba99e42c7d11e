//! What glossy leaves reflect toward the eye, on the GPU.

use super::{
    GpuImplicit,
    forest::{GpuForest, cos_sin},
    light::cells_of_sky,
};
use crate::{
    device::{
        buffers::{storage, uniform, written},
        kernel::Kernel,
        kernels::Glossy,
        layout::{GlossUniforms, GlossyLeaf, Reflected},
        readback::read_range,
        tables::tables,
    },
    error::BackendError,
};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::{Mat3, Vec3, Vec3A, Vec4};
use lapidary_core::{brdf::BrdfModel, implicit::Sky};
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
    sky: wgpu::Buffer,
    reflected: wgpu::Buffer,
}

/// What is reflected where.
pub struct GlossRequest<'a> {
    /// Shading frame of each glossy leaf: tangent, bitangent and normal as columns.
    pub frames: &'a [Mat3],
    /// Position of the eye in meters.
    pub eye: Vec3,
    /// Radiance that each node of the forest sends, if leaves reflect it too.
    pub sent: Option<&'a [Vec3A]>,
    pub sky: Sky<'a>,
}

/// What a leaf reflects toward the eye, as radiance in W/(m² sr).
#[derive(Clone, Copy, Debug, Default)]
pub struct ReflectedLight {
    /// Of the sky.
    pub sky: Vec3,
    /// Of the leaves that it sees.
    pub leaves: Vec3,
    /// Irradiance from these leaves, in W/m².
    pub irradiance: Vec3,
}

impl GpuForest {
    /// Takes glossy leaves, one or more, and the values of the parameters of their models. `None` if there is no room for them.
    pub fn gloss_table(&self, kernel: Arc<Kernel>, leaves: Vec<LeafLobes>, values: &[Vec4]) -> Option<GlossTable> {
        let gpu = &self.on.gpu;
        let bytes = |count: usize, size: usize| (count * size) as u64;
        let of_nodes = bytes(self.nodes as usize, size_of::<Vec4>());
        let of_leaves = bytes(leaves.len(), size_of::<Reflected>());
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
            sky: storage(gpu, "sky of glossy leaves", cast_slice(&cells_of_sky(&|_| Vec3::ZERO))),
            reflected: written(gpu, "light that leaves reflect", of_leaves),
            leaves,
        })
    }

    /// What the leaves of a table reflect toward the eye, by what they saw at the last walk; `None` for those that face away.
    ///
    /// # Errors
    /// A lost device.
    pub fn gloss(&self, table: &GlossTable, asked: &GlossRequest) -> Result<Vec<Option<ReflectedLight>>, BackendError> {
        let (GpuImplicit { gpu, .. }, b) = (&self.on, &self.buffers);
        let uniforms = GlossUniforms {
            eye: asked.eye.into(),
            side: self.layout.cells.side as u32,
            turn: cos_sin(self.layout.turn),
            has_sent: u32::from(asked.sent.is_some()),
            padding: 0,
        };
        gpu.queue.write_buffer(&table.uniforms, 0, bytes_of(&uniforms));
        let leaves: Vec<GlossyLeaf> = table.leaves.iter().zip(asked.frames).map(packed).collect();
        gpu.queue.write_buffer(&table.materials, 0, cast_slice(&leaves));
        gpu.queue.write_buffer(&table.sky, 0, cast_slice(&cells_of_sky(asked.sky)));
        if let Some(sent) = asked.sent {
            let wide: Vec<Vec4> = sent.iter().map(|radiance| radiance.extend(0.0)).collect();
            gpu.queue.write_buffer(&table.sent, 0, cast_slice(&wide));
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
            sky: &table.sky,
            reflected: &table.reflected,
        };
        table.kernel.run(gpu, &[glossy.bind(gpu)], leaves.len() as u32)?;
        let found: Vec<Reflected> = read_range(gpu, &table.reflected, 0..leaves.len())?;
        Ok(found.iter().map(unpacked).collect())
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

fn unpacked(of: &Reflected) -> Option<ReflectedLight> {
    let color = |of: [f32; 4]| Vec4::from_array(of).truncate();
    let Reflected { sky, faces_eye, leaves, irradiance } = *of;
    (faces_eye != 0).then(|| ReflectedLight { sky: sky.into(), leaves: color(leaves), irradiance: color(irradiance) })
}
