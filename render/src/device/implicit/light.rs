//! Light of the leaves of a forest on the GPU, bounce by bounce.

use super::{
    GpuImplicit,
    forest::{GpuForest, cos_sin},
};
use crate::{
    device::{
        adapter::GpuDevice,
        buffers::{storage, uniform, written},
        kernels,
        layout::{
            LeafIrradiance, LeafLighting, LeafValue, LightUniforms,
            constants::{SENDS_ALL, SENDS_EMISSION, SENDS_LAST},
        },
        readback::read_range,
    },
    error::BackendError,
};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::{Vec3, Vec4};
use lapidary_core::{
    implicit::{BinLayout, Lighting, Sky},
    sphere::octahedron,
};
use std::time::Duration;

/// Irradiance of the leaves of a forest in W/m², one entry each.
#[derive(Clone, Debug)]
pub struct SeenLight {
    /// From the sky alone.
    pub of_sky: Vec<Vec3>,
    /// By what emits: the sky and other leaves.
    pub direct: Vec<Vec3>,
    /// By all bounces.
    pub bounced: Vec<Vec3>,
}

/// What kernels of light read and write.
pub(super) struct LightBuffers {
    uniforms: wgpu::Buffer,
    pub lighting: wgpu::Buffer,
    pub sky: wgpu::Buffer,
    /// Of the nodes.
    radiance: wgpu::Buffer,
    /// Of the leaves.
    pub irradiance: wgpu::Buffer,
    /// Of the leaves, as vertices take it.
    pub values: wgpu::Buffer,
}

impl LightBuffers {
    pub fn new(gpu: &GpuDevice, leaves: u32, nodes: u32) -> Self {
        let bytes = |count: u32, size: usize| u64::from(count) * size as u64;
        Self {
            uniforms: uniform(gpu, "light of leaves", bytes_of(&LightUniforms::zeroed())),
            lighting: written(gpu, "lighting of leaves", bytes(leaves, size_of::<LeafLighting>())),
            sky: storage(gpu, "sky", cast_slice(&[Vec4::ZERO; octahedron::CELLS])),
            radiance: written(gpu, "radiance of nodes", bytes(nodes, size_of::<Vec4>())),
            irradiance: written(gpu, "irradiance of leaves", bytes(leaves, size_of::<LeafIrradiance>())),
            values: written(gpu, "light of leaves for vertices", bytes(leaves, size_of::<LeafValue>())),
        }
    }
}

impl GpuForest {
    /// Irradiance of the leaves up to so many bounces, by what they saw at the last walk. Of the sky the values at the middles of the cells of an octahedron count ([`octahedron`]).
    ///
    /// # Errors
    /// A lost device.
    pub fn light(&mut self, lighting: &Lighting, bounces: u32) -> Result<SeenLight, BackendError> {
        self.relight(lighting, bounces)?;
        let light: Vec<LeafIrradiance> = read_range(&self.on.gpu, &self.light.irradiance, 0..self.leaves as usize)?;
        let part = |of: fn(&LeafIrradiance) -> [f32; 4]| light.iter().map(|leaf| color(of(leaf))).collect();
        Ok(SeenLight {
            of_sky: part(|leaf| leaf.of_sky),
            direct: part(|leaf| leaf.direct),
            bounced: part(|leaf| leaf.bounced),
        })
    }

    /// The same, kept on the device alone.
    ///
    /// # Errors
    /// As [`Self::light`].
    pub fn relight(&mut self, lighting: &Lighting, bounces: u32) -> Result<(), BackendError> {
        let gpu = &self.on.gpu;
        gpu.queue.write_buffer(&self.light.lighting, 0, cast_slice(&packed_lighting(lighting)));
        gpu.queue.write_buffer(&self.light.sky, 0, cast_slice(&cells_of_sky(lighting.sky)));
        (self.times.pull, self.times.bounce) = Default::default();
        self.gather(SENDS_EMISSION)?;
        (0..bounces).try_for_each(|_| self.gather(SENDS_LAST))
    }

    /// Radiance that nodes send into the picture, into a buffer with a vector for each.
    pub(super) fn pull_all(&self, into: &wgpu::Buffer) -> Result<(), BackendError> {
        self.pull(SENDS_ALL, into).map(drop)
    }

    /// Radiance of the nodes by what leaves send. Returns how long it took.
    fn pull(&self, sends: u32, into: &wgpu::Buffer) -> Result<Duration, BackendError> {
        let (GpuImplicit { gpu, kernels: on }, b, l) = (&self.on, &self.buffers, &self.light);
        let BinLayout { cells, turn } = self.layout;
        let uniforms = LightUniforms { turn: cos_sin(turn), sends, side: cells.side as u32 };
        gpu.queue.write_buffer(&l.uniforms, 0, bytes_of(&uniforms));
        let pulled = kernels::Pulled {
            uniforms: &l.uniforms,
            discs: &b.discs,
            spans: &b.spans,
            lighting: &l.lighting,
            light: &l.irradiance,
            radiance: into,
        };
        on.pull.run(gpu, &[pulled.bind(gpu)], self.nodes)
    }

    /// One bounce of what leaves send; with emission the sky, too.
    fn gather(&mut self, sends: u32) -> Result<(), BackendError> {
        self.times.pull += self.pull(sends, &self.light.radiance)?;
        let (GpuImplicit { gpu, kernels: on }, b, l) = (&self.on, &self.buffers, &self.light);
        let gathered = kernels::Gathered {
            uniforms: &l.uniforms,
            discs: &b.discs,
            views: &b.views,
            directions: &b.directions,
            radiance: &l.radiance,
            lighting: &l.lighting,
            sky: &l.sky,
            light: &l.irradiance,
        };
        self.times.bounce += on.bounce.run(gpu, &[gathered.bind(gpu)], self.leaves)?;
        Ok(())
    }
}

fn packed_lighting(lighting: &Lighting) -> Vec<LeafLighting> {
    let leaves = lighting.reflectance.iter().zip(lighting.emitted).zip(lighting.received);
    let wide = |value: &Vec3| value.extend(0.0).to_array();
    let packed = |((reflectance, emitted), received)| LeafLighting {
        reflectance: wide(reflectance),
        emitted: wide(emitted),
        received: wide(received),
    };
    leaves.map(packed).collect()
}

fn cells_of_sky(sky: Sky) -> Vec<Vec4> {
    (0..octahedron::CELLS).map(|cell| sky(octahedron::direction_of(cell)).extend(0.0)).collect()
}

fn color([x, y, z, _]: [f32; 4]) -> Vec3 {
    Vec3::new(x, y, z)
}
