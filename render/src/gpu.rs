//! The GPU renderer (paper, 4.2): deferred passes, then one fragment shader that merges the cuts. Portable: WebGPU's
//! default limits and no optional feature are enough. It is the twin of the CPU renderer and is tested against it.

mod addition;
mod backend;
mod compute;
mod device;
mod direct;
mod frame;
mod implicit;
mod layout;
mod light;
mod lit;
mod materials;
mod measured;
mod meshless;
mod models;
mod passes;
mod pipeline;
mod pool;
mod posed;
mod rays;
mod readback;
mod scene;
mod shaders;
mod shadows;
mod targets;
mod written;

pub use backend::{GpuBackend, PassTimes};
pub use device::{Room, has_hardware};
pub use implicit::{ForestTimes, GpuForest, GpuImplicit};
pub use rays::GpuRays;
pub use shaders::ShaderSource;

#[cfg(test)]
mod tests;
