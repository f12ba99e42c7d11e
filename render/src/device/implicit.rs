//! Implicit visibility on the GPU (Dong et al., *Interactive Global Illumination Using Implicit Visibility*, 2007): a surfel forest under
//! one pose after another, what its leaves see, and their light. Twin of `lapidary_core::implicit`.
//!
//! Its kernels are each a dispatch over all leaves, nodes or vertices: none waits for a level of the tree below. Nodes and bins have the
//! bits of the twin where the adapter rounds as IEEE 754 says; light differs by the order of sums.

mod cuts;
mod forest;
mod gloss;
mod light;
mod vertices;

pub use cuts::{CutRequest, CutTables, DeviceCuts};
pub use forest::GpuForest;
pub(crate) use gloss::{GlossRequest, GlossTable, LeafLobes};
pub use light::SeenLight;
pub(crate) use vertices::{LeavesBeside, VertexPlanes, VertexRequest};

use super::{
    adapter::GpuDevice,
    compute::SharedDevice,
    kernel::Kernel,
    kernels::{
        IMPLICIT_BOUNCE, IMPLICIT_CUTS_COUNT, IMPLICIT_CUTS_WRITE, IMPLICIT_LEAVES, IMPLICIT_NODES, IMPLICIT_PULL,
        IMPLICIT_UPDATE, IMPLICIT_VERTICES, IMPLICIT_WALK, REPLACED_CUTS,
    },
};
use crate::error::BackendError;
use lapidary_core::implicit::{BinLayout, forest::SurfelForest};
use std::{sync::Arc, time::Duration};

/// An adapter that finds what the leaves of forests see.
#[derive(Clone)]
pub struct GpuImplicit {
    gpu: GpuDevice,
    kernels: Kernels,
}

#[derive(Clone)]
struct Kernels {
    update: Arc<Kernel>,
    nodes: Arc<Kernel>,
    walk: Arc<Kernel>,
    pull: Arc<Kernel>,
    bounce: Arc<Kernel>,
    leaves: Arc<Kernel>,
    vertices: Arc<Kernel>,
    cuts_count: Arc<Kernel>,
    cuts_write: Arc<Kernel>,
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
    /// On a device.
    ///
    /// # Errors
    /// A driver that refuses.
    pub fn on(device: &SharedDevice) -> Result<Self, BackendError> {
        // Whoever takes the cuts does not wait for its compiler.
        device.kernel(&REPLACED_CUTS)?;
        let kernels = Kernels {
            update: device.kernel(&IMPLICIT_UPDATE)?,
            nodes: device.kernel(&IMPLICIT_NODES)?,
            walk: device.kernel(&IMPLICIT_WALK)?,
            pull: device.kernel(&IMPLICIT_PULL)?,
            bounce: device.kernel(&IMPLICIT_BOUNCE)?,
            leaves: device.kernel(&IMPLICIT_LEAVES)?,
            vertices: device.kernel(&IMPLICIT_VERTICES)?,
            cuts_count: device.kernel(&IMPLICIT_CUTS_COUNT)?,
            cuts_write: device.kernel(&IMPLICIT_CUTS_WRITE)?,
        };
        Ok(Self { gpu: (*device.gpu).clone(), kernels })
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
