//! Implicit visibility on the GPU (Dong et al., *Interactive Global Illumination Using Implicit Visibility*, 2007): a surfel forest under
//! one pose after another, what its leaves see, and their light. Twin of `lapidary_core::implicit`.
//!
//! Five kernels, each a dispatch over all leaves or all nodes: none waits for a level of the tree below. Nodes and bins have the bits of
//! the twin where the adapter rounds as IEEE 754 says; light differs by the order of sums.

mod forest;
mod light;
mod sight;

pub use forest::GpuForest;

use super::{
    compute::Kernel,
    device::{GpuDevice, Room},
    pipeline::Binding::{Storage, Uniform, Written},
    shaders::{IMPLICIT_BOUNCE, IMPLICIT_NODES, IMPLICIT_PULL, IMPLICIT_UPDATE, IMPLICIT_WALK},
};
use crate::backend::BackendError;
use lapidary_core::{implicit::BinLayout, surfel::forest::SurfelForest};
use std::{sync::Arc, time::Duration};

/// An adapter that finds what the leaves of forests see.
#[derive(Clone)]
pub struct GpuImplicit {
    gpu: GpuDevice,
    kernels: Arc<Kernels>,
}

struct Kernels {
    update: Kernel,
    nodes: Kernel,
    walk: Kernel,
    pull: Kernel,
    bounce: Kernel,
}

/// How long the last work of each kind took, with the wait for it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForestTimes {
    /// Leaves and nodes at new positions of the vertices.
    pub update: Duration,
    /// What leaves see.
    pub walk: Duration,
    /// Radiance of nodes, for all bounces.
    pub pull: Duration,
    /// Irradiance of leaves, of all bounces.
    pub bounce: Duration,
}

impl GpuImplicit {
    /// On the fastest adapter.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses.
    pub fn new(room: Room) -> Result<Self, BackendError> {
        Self::on(GpuDevice::new(room)?)
    }

    /// On a device that others use too.
    ///
    /// # Errors
    /// A driver that refuses.
    pub(super) fn on(gpu: GpuDevice) -> Result<Self, BackendError> {
        let kernel = |program, bindings: &[_]| Kernel::new(&gpu, program, bindings);
        let kernels = Kernels {
            update: kernel(&IMPLICIT_UPDATE, &[Storage, Storage, Written])?,
            nodes: kernel(&IMPLICIT_NODES, &[Storage, Storage, Written])?,
            walk: kernel(&IMPLICIT_WALK, &[Uniform, Storage, Storage, Storage, Storage, Storage, Written])?,
            pull: kernel(&IMPLICIT_PULL, &[Uniform, Storage, Storage, Storage, Storage, Written])?,
            bounce: kernel(
                &IMPLICIT_BOUNCE,
                &[Uniform, Storage, Storage, Storage, Storage, Storage, Storage, Written],
            )?,
        };
        Ok(Self { gpu, kernels: Arc::new(kernels) })
    }

    /// The name of the adapter.
    pub fn name(&self) -> &str {
        &self.gpu.info.name
    }

    /// Takes a forest with at least one leaf, on a mesh of so many vertices, and its pose.
    ///
    /// # Errors
    /// A forest beyond the limits of the adapter, or a lost device.
    pub fn forest(&self, forest: &SurfelForest, vertices: usize, layout: BinLayout) -> Result<GpuForest, BackendError> {
        GpuForest::new(self.clone(), forest, vertices, layout)
    }
}

#[cfg(test)]
mod tests;
