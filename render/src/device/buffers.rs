//! Buffers with contents.

use super::adapter::GpuDevice;

/// A read-only storage buffer.
pub fn storage(gpu: &GpuDevice, label: &str, contents: &[u8]) -> wgpu::Buffer {
    filled(gpu, label, wgpu::BufferUsages::STORAGE, contents)
}

/// A buffer of uniforms.
pub fn uniform(gpu: &GpuDevice, label: &str, contents: &[u8]) -> wgpu::Buffer {
    filled(gpu, label, wgpu::BufferUsages::UNIFORM, contents)
}

fn filled(gpu: &GpuDevice, label: &str, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
    // Not mapped at creation: mapping panics on a lost device, writing reports it.
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: contents.len() as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, contents);
    buffer
}
