//! What posed objects change of the light, for the passes that shade.

use super::scene::{empty_float_texture, extent, float_texture};
use crate::{
    device::{
        GpuDevice, VertexPlanes,
        layout::constants::{POSED_BOUNCE, POSED_PLANES, POSED_UNCOVERED},
    },
    light::implicit::{DeviceLight, PosedLight, PosedLighting, Sides},
};
use rayon::prelude::*;

const LABEL: &str = "posed light";

/// The texture that `posed.wgsl` reads: two texels for each vertex in each of its planes, or one in all where nothing is posed. Without
/// the environment nothing is uncovered to it.
pub fn texture(gpu: &GpuDevice, light: Option<&PosedLighting>, shows_environment: bool) -> wgpu::TextureView {
    let Some(light) = light else { return float_texture(gpu, LABEL, [1, 1], &[[0.0; 4]]) };
    match light.there(gpu) {
        Some(light) => copied(gpu, light, shows_environment),
        None => uploaded(gpu, light.known(), shows_environment),
    }
}

/// That of planes on the device, without those that are not shown.
fn copied(gpu: &GpuDevice, light: &DeviceLight, shows_environment: bool) -> wgpu::TextureView {
    let (width, rows) = (VertexPlanes::WIDTH, light.planes.own_rows());
    let texture = empty_float_texture(gpu, LABEL, [width, POSED_PLANES * rows]);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(width * size_of::<[f32; 4]>() as u32),
        rows_per_image: None,
    };
    let is_shown =
        |plane: &u32| (*plane != POSED_BOUNCE || light.has_bounces) && (*plane != POSED_UNCOVERED || shows_environment);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for first_row in (0..POSED_PLANES).filter(is_shown).map(|plane| plane * rows) {
        let offset = u64::from(first_row) * u64::from(width) * size_of::<[f32; 4]>() as u64;
        let layout = wgpu::TexelCopyBufferLayout { offset, ..layout };
        let origin = wgpu::Origin3d { x: 0, y: first_row, z: 0 };
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo { buffer: &light.planes.texels, layout },
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            extent([width, rows]),
        );
    }
    gpu.queue.submit([encoder.finish()]);
    texture.create_view(&Default::default())
}

/// That of light on the cores.
fn uploaded(gpu: &GpuDevice, light: &PosedLight, shows_environment: bool) -> wgpu::TextureView {
    let PosedLight { is_moved, growth, uncovered, bounce } = light;
    let (width, rows) = (VertexPlanes::WIDTH, VertexPlanes::rows(is_moved.len() as u32));
    let plane = |sides: &Sides, alpha: &(dyn Fn(usize) -> f32 + Sync)| {
        let both = |vertex: usize| [sides.front[vertex], sides.back[vertex]].map(|of| of.extend(alpha(vertex)).into());
        let mut texels: Vec<[f32; 4]> =
            (0..is_moved.len()).into_par_iter().map(both).collect::<Vec<[[f32; 4]; 2]>>().into_flattened();
        texels.resize((width * rows) as usize, [0.0; 4]);
        texels
    };
    let nothing = || vec![[0.0; 4]; (width * rows) as usize];
    let planes: [Vec<[f32; 4]>; POSED_PLANES as usize] = [
        plane(growth, &|_| 0.0),
        plane(bounce, &|vertex| f32::from(u8::from(is_moved[vertex]))),
        if shows_environment { plane(uncovered, &|_| 0.0) } else { nothing() },
    ];
    float_texture(gpu, LABEL, [width, POSED_PLANES * rows], &planes.concat())
}
