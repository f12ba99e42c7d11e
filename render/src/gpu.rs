//! The GPU renderer (paper, 4.2): deferred passes, then one fragment shader that merges the cuts. Portable: WebGPU's
//! default limits and no optional feature are enough. It is the twin of the CPU renderer and is tested against it.

mod backend;
mod direct;
mod draw;
mod entries;
mod frame;
mod groups;
mod light;
mod lit;
mod materials;
mod measured;
mod meshless;
mod passes;
mod picture_rays;
mod pool;
mod posed;
mod probe;
mod scene;
mod shadows;
mod targets;
mod turned;
mod wavelet;

pub use crate::device::{
    AdapterFacts, Compute, ForestTimes, GpuForest, GpuImplicit, GpuRays, Room, ShaderSource, SharedDevice,
    has_hardware, pass::GpuPath,
};
pub use backend::{GpuBackend, PassTimes};
pub use probe::faster_path;

#[cfg(test)]
mod tests;
