//! Light of a turned environment on the GPU: kernels compute the nodes of the tree of light samples. Twin of [`TurnedMap::lighting`].
//!
//! What does not depend on rotation and intensity is uploaded once: the matrix of the samples and the tree for a scene, the energy of the
//! grid for a map.

use super::light::NodeBuffers;
use crate::{
    device::{
        GpuDevice, Kernel, Shaders, SharedDevice,
        kernels::{KernelProgram, TURNED_LEAVES, TURNED_MEANS, TURNED_NODES, TurnedLeaves, TurnedMeans, TurnedNodes},
        layout::{Means, MeansUniforms, Node, TurnedUniforms},
        storage, uniform, written,
    },
    error::BackendError,
    light::environment::{LightSamples, SampledMap, TurnedMap},
};
use bytemuck::Zeroable;
use lapidary_core::light_tree::{LightTree, NodeLight};
use std::sync::Arc;

/// Leaves, parents and nodes that one workgroup computes, as in the kernels.
const LEAVES_PER_GROUP: u32 = 8;
const PARENTS_PER_GROUP: u32 = 128;
const NODES_PER_GROUP: u32 = 64;

/// The light samples of a scene, and the light of their tree as it was computed last.
pub struct GpuSamples {
    samples: Arc<LightSamples>,
    kernels: TurnedKernels,
    uniforms: wgpu::Buffer,
    matrix: GpuMatrix,
    /// Direction and radius of each node without light.
    plain: wgpu::Buffer,
    means: wgpu::Buffer,
    nodes: NodeBuffers,
    map: Option<GpuSampledMap>,
}

struct TurnedKernels {
    leaves: Arc<Kernel>,
    means: Arc<Kernel>,
    nodes: Arc<Kernel>,
}

/// Which part of which cell each leaf takes.
struct GpuMatrix {
    starts: wgpu::Buffer,
    cells: wgpu::Buffer,
}

/// A map on the grid.
struct GpuSampledMap {
    map: Arc<SampledMap>,
    energy: wgpu::Buffer,
}

impl TurnedKernels {
    fn new(device: &SharedDevice, shaders: &Shaders) -> Result<Self, BackendError> {
        let kernel = |program: &KernelProgram| device.kernel_from(shaders, program, &[]);
        Ok(Self { leaves: kernel(&TURNED_LEAVES)?, means: kernel(&TURNED_MEANS)?, nodes: kernel(&TURNED_NODES)? })
    }
}

impl GpuMatrix {
    /// Uploads some megabytes.
    fn new(gpu: &GpuDevice, LightSamples { tree, sampler }: &LightSamples) -> Self {
        let (mut starts, mut cells) = (vec![0_u32], Vec::new());
        for &sample in tree.order() {
            cells.extend(sampler.cells_of(sample as usize).iter().map(|&(cell, part)| [cell, part.to_bits()]));
            starts.push(cells.len() as u32);
        }
        Self {
            starts: storage(gpu, "first cells of light samples", bytemuck::cast_slice(&starts)),
            cells: storage(gpu, "cells of light samples", bytemuck::cast_slice(&cells)),
        }
    }
}

impl GpuSamples {
    /// Compiles the kernels, and uploads the samples.
    ///
    /// # Errors
    /// A lost device, or one that has no room.
    pub fn new(device: &SharedDevice, shaders: &Shaders, samples: &Arc<LightSamples>) -> Result<Self, BackendError> {
        let (gpu, nodes) = (&*device.gpu, 2 * samples.tree.len());
        let made = Self {
            samples: samples.clone(),
            kernels: TurnedKernels::new(device, shaders)?,
            uniforms: uniform(gpu, "a turned map", bytemuck::bytes_of(&TurnedUniforms::zeroed())),
            matrix: GpuMatrix::new(gpu, samples),
            plain: plain(gpu, &samples.tree),
            means: written(gpu, "means of light samples", (nodes * size_of::<Means>()) as u64),
            nodes: NodeBuffers {
                nodes: written(gpu, "light of a turned map", (nodes * size_of::<Node>()) as u64),
                brightness: written(gpu, "brightness under a turned map", (nodes * size_of::<f32>()) as u64),
            },
            map: None,
        };
        gpu.check().map(|()| made)
    }

    /// Whether it is of these samples.
    pub fn is_of(&self, samples: &Arc<LightSamples>) -> bool {
        Arc::ptr_eq(&self.samples, samples)
    }

    /// Computes the light of a map. It replaces that of the map before in the same buffers.
    ///
    /// # Errors
    /// A lost device, or one that has no room for the map.
    pub fn light(&mut self, gpu: &GpuDevice, turned: &TurnedMap) -> Result<NodeBuffers, BackendError> {
        gpu.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms(turned)));
        let map = self.map.take().filter(|before| Arc::ptr_eq(&before.map, &turned.map));
        let map = self.map.insert(map.unwrap_or_else(|| GpuSampledMap::new(gpu, &turned.map)));
        let leaves = TurnedLeaves {
            turned: &self.uniforms,
            starts: &self.matrix.starts,
            cells: &self.matrix.cells,
            energy: &map.energy,
            plain: &self.plain,
            means: &self.means,
        };
        let count = self.samples.tree.len() as u32;
        self.kernels.leaves.run(gpu, &[leaves.bind(gpu)], count.div_ceil(LEAVES_PER_GROUP))?;
        self.average(gpu, count)?;
        let NodeBuffers { nodes, brightness } = &self.nodes;
        let finished =
            TurnedNodes { turned: &self.uniforms, means: &self.means, plain: &self.plain, nodes, brightness };
        self.kernels.nodes.run(gpu, &[finished.bind(gpu)], (2 * count).div_ceil(NODES_PER_GROUP))?;
        Ok(self.nodes.clone())
    }

    /// Takes means from `known` nodes of a level up to the root.
    fn average(&self, gpu: &GpuDevice, mut known: u32) -> Result<(), BackendError> {
        while known > 1 {
            let parents = known / 2;
            let level = uniform(gpu, "level of means", bytemuck::bytes_of(&MeansUniforms { parents }));
            let groups = parents.div_ceil(PARENTS_PER_GROUP);
            self.kernels.means.run(gpu, &[TurnedMeans { level: &level, means: &self.means }.bind(gpu)], groups)?;
            // The root of each group's nodes is known now.
            known = groups;
        }
        Ok(())
    }
}

impl GpuSampledMap {
    fn new(gpu: &GpuDevice, map: &Arc<SampledMap>) -> Self {
        let energy = storage(gpu, "energy of a map", bytemuck::cast_slice(map.energy.cells()));
        Self { map: map.clone(), energy }
    }
}

fn plain(gpu: &GpuDevice, tree: &LightTree) -> wgpu::Buffer {
    let nodes = tree.mean_directions().iter().zip(tree.radii());
    let nodes: Vec<[f32; 4]> = nodes.map(|(direction, &radius)| direction.extend(radius).to_array()).collect();
    storage(gpu, "nodes without light", bytemuck::cast_slice(&nodes))
}

fn uniforms(turned: &TurnedMap) -> TurnedUniforms {
    let LightSamples { tree, sampler } = &*turned.samples;
    let shift = sampler.shift(turned.rotation);
    TurnedUniforms {
        columns: sampler.columns() as u32,
        shift: shift.columns,
        fraction: shift.fraction,
        samples_per_steradian: sampler.samples_per_steradian(),
        intensity: turned.intensity,
        leaves: tree.len() as u32,
        leaf_spread: NodeLight::leaf_spread(tree.len()),
    }
}
