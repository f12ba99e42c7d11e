//! Tables that the texts of materials and BRDFs read.

use super::{adapter::GpuDevice, buffers::uniform, layout::Tables};
use bytemuck::bytes_of;
use lapidary_core::{brdf::albedo_table, color::LINEAR_FROM_CODE};

/// Linear values of the 256 sRGB codes, as a shader's own power function is too coarse; and the albedos of lobes.
pub fn tables(gpu: &GpuDevice) -> wgpu::Buffer {
    let tables = Tables { linear_from_srgb: *LINEAR_FROM_CODE, albedo: *albedo_table() };
    uniform(gpu, "tables", bytes_of(&tables))
}
