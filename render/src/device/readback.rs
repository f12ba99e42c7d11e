//! Buffers and textures back from the GPU.

use super::adapter::GpuDevice;
use crate::error::BackendError;
use std::ops::Range;

/// The first word of a buffer.
///
/// # Errors
/// A lost device.
pub fn read_word(gpu: &GpuDevice, from: &wgpu::Buffer) -> Result<u32, BackendError> {
    Ok(read_words(gpu, from, 1)?[0])
}

/// The first words of a buffer, one or more.
///
/// # Errors
/// A lost device.
pub fn read_words(gpu: &GpuDevice, from: &wgpu::Buffer, count: usize) -> Result<Vec<u32>, BackendError> {
    read_range(gpu, from, 0..count)
}

/// Some of the elements of a buffer, one or more, of four bytes or a multiple each.
///
/// # Errors
/// A lost device.
pub fn read_range<T: bytemuck::Pod>(
    gpu: &GpuDevice,
    from: &wgpu::Buffer,
    range: Range<usize>,
) -> Result<Vec<T>, BackendError> {
    let size = size_of::<T>() as u64;
    let bytes = range.len() as u64 * size;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_buffer_to_buffer(from, range.start as u64 * size, &buffer, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    gpu.wait()?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| BackendError::Driver(e.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec(&mapped))
}

/// The bytes of a whole texture, row by row without padding.
///
/// # Errors
/// A lost device.
pub fn read(gpu: &GpuDevice, texture: &wgpu::Texture) -> Result<Vec<u8>, BackendError> {
    let texel = texture.format().block_copy_size(None).unwrap_or(16);
    let row = texel * texture.width();
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded) * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    gpu.wait()?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| BackendError::Driver(e.to_string()))?;
    let bytes = mapped.chunks(padded as usize).flat_map(|r| &r[..row as usize]).copied().collect();
    Ok(bytes)
}
