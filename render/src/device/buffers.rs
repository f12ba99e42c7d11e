//! Buffers with contents.

use super::adapter::GpuDevice;
use wgpu::BufferUsages as Usages;

/// A read-only storage buffer.
pub fn storage(gpu: &GpuDevice, label: &str, contents: &[u8]) -> wgpu::Buffer {
    filled(gpu, label, Usages::STORAGE, contents)
}

/// A buffer of uniforms.
pub fn uniform(gpu: &GpuDevice, label: &str, contents: &[u8]) -> wgpu::Buffer {
    filled(gpu, label, Usages::UNIFORM, contents)
}

/// A storage buffer that kernels write and that is read back.
pub fn written(gpu: &GpuDevice, label: &str, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: Usages::STORAGE | Usages::COPY_SRC | Usages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn filled(gpu: &GpuDevice, label: &str, usage: Usages, contents: &[u8]) -> wgpu::Buffer {
    // Not mapped at creation: mapping panics on a lost device, writing reports it.
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: contents.len() as u64,
        usage: usage | Usages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, contents);
    buffer
}
