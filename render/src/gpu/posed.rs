//! What posed objects change of the light, for the passes that shade.

use super::{
    device::GpuDevice,
    scene::{extent, write_rows},
};
use crate::light::implicit::{PosedLight, Sides};
use glam::Vec3;

/// Texels in a row, of which six belong to a vertex.
const WIDTH: usize = 8192;

/// The texture that `posed.wgsl` reads: some texels for each vertex, or one in all where nothing is posed. Without
/// the environment nothing is uncovered to it.
pub fn texture(gpu: &GpuDevice, light: Option<&PosedLight>, shows_environment: bool) -> wgpu::TextureView {
    let (size, texels) = match light {
        Some(light) => {
            let mut texels = texels(light, shows_environment);
            texels.resize(texels.len().next_multiple_of(WIDTH).max(WIDTH), [0.0; 4]);
            ([WIDTH as u32, (texels.len() / WIDTH) as u32], texels)
        }
        None => ([1, 1], vec![[0.0; 4]]),
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("posed light"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    write_rows(gpu, &texture, size[0] as usize * size_of::<[f32; 4]>(), bytemuck::cast_slice(&texels));
    texture.create_view(&Default::default())
}

fn texels(light: &PosedLight, shows_environment: bool) -> Vec<[f32; 4]> {
    let PosedLight { is_moved, growth, uncovered, bounce } = light;
    let of_vertex = |(vertex, &moved): (usize, &bool)| {
        let sides = [growth, bounce, uncovered].map(|Sides { front, back }| [front[vertex], back[vertex]]);
        let alpha = f32::from(u8::from(moved));
        let mut texels: [Vec3; 6] = std::array::from_fn(|i| sides[i / 2][i % 2]);
        if !shows_environment {
            texels[4..].fill(Vec3::ZERO);
        }
        texels.map(|texel| texel.extend(alpha))
    };
    is_moved.iter().enumerate().flat_map(of_vertex).map(|texel| texel.to_array()).collect()
}
