//! What posed objects change of the light, for the passes that shade.

use super::scene::float_texture;
use crate::{
    device::GpuDevice,
    light::implicit::{PosedLight, Sides},
};
use glam::Vec3;
use rayon::prelude::*;

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
    float_texture(gpu, "posed light", size, &texels)
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
        texels.map(|texel| texel.extend(alpha).to_array())
    };
    let each: Vec<[[f32; 4]; 6]> = is_moved.par_iter().enumerate().map(of_vertex).collect();
    each.into_flattened()
}
