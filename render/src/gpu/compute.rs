//! Compute passes: kernels of one WGSL file each, whose work is cut into slices of a few milliseconds. Within WebGPU's default limits.

mod kernel;
mod pace;

pub use kernel::Kernel;
