//! The GPU renderer (paper, 4.2): deferred passes, then one fragment shader that merges the cuts. Portable: WebGPU's
//! default limits and no optional feature are enough. It is the twin of the CPU renderer and is tested against it.

mod backend;
mod direct;
mod entries;
mod frame;
mod groups;
mod light;
mod lit;
mod materials;
mod measured;
mod meshless;
mod passes;
mod pipeline;
mod pool;
mod posed;
mod scene;
mod shadows;
mod targets;
mod wavelet;

pub use crate::device::{
    Compute, ForestTimes, GpuForest, GpuImplicit, GpuRays, Room, ShaderSource, SharedDevice, has_hardware,
};
pub use backend::{GpuBackend, PassTimes};

#[cfg(test)]
mod tests;
