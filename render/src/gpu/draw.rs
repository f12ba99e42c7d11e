//! Passes as commands: over every pixel or some areas, by fragments or by kernels.

use super::{groups::Frame, targets::Target};
use crate::device::{
    Bound, GpuDevice,
    layout::constants::{MOST_AREAS, TILE_SIDE},
    output::Output,
    pass::{Pass, Pipeline},
    uniform,
};
use lapidary_core::image::Region;

/// Uniforms of a frame, and the group by which fragments read them.
pub struct BoundFrame {
    uniforms: wgpu::Buffer,
    pub group: wgpu::BindGroup,
}

impl BoundFrame {
    pub fn new(gpu: &GpuDevice, uniforms: &wgpu::Buffer) -> Self {
        Self { uniforms: uniforms.clone(), group: Frame { frame: uniforms }.bind(gpu) }
    }
}

/// Sets what a pass that draws is, and what it reads.
pub fn bind(drawing: &mut wgpu::RenderPass, pass: &Pass, groups: &[&wgpu::BindGroup]) {
    let Pipeline::Fragments(pipeline) = pass.pipeline() else { unreachable!("{} has no kernel", pass.label) };
    drawing.set_pipeline(pipeline);
    for (i, group) in (0..).zip(groups) {
        drawing.set_bind_group(i, *group, &[]);
    }
}

/// A pass without a kernel over every pixel.
pub fn full_screen(encoder: &mut wgpu::CommandEncoder, pass: &Pass, outputs: &[&Target], groups: &[&wgpu::BindGroup]) {
    let attachments: Vec<_> = outputs.iter().map(|target| cleared(target)).collect();
    let mut drawing = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(pass.label),
        color_attachments: &attachments,
        ..Default::default()
    });
    bind(&mut drawing, pass, groups);
    drawing.draw(0..3, 0..1);
}

/// A pass over some areas, which keeps the rest of what it writes. `groups` are those after the frame.
pub fn encode_areas(
    encoder: &mut wgpu::CommandEncoder,
    pass: &Pass,
    frame: &BoundFrame,
    groups: &[&wgpu::BindGroup],
    outputs: &[&Target],
    areas: &[Region],
) {
    match pass.pipeline() {
        Pipeline::Fragments(_) => {
            let attachments: Vec<_> = outputs.iter().map(|target| attachment(target, wgpu::LoadOp::Load)).collect();
            let mut drawing = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(pass.label),
                color_attachments: &attachments,
                ..Default::default()
            });
            bind(&mut drawing, pass, &[&[&frame.group], groups].concat());
            for area in areas {
                drawing.set_scissor_rect(area.x, area.y, area.width, area.height);
                drawing.draw(0..3, 0..1);
            }
        }
        Pipeline::Kernel(pipeline, output) => {
            let mut computing = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(pass.label), timestamp_writes: None });
            computing.set_pipeline(pipeline);
            for (i, group) in (1..).zip(groups) {
                computing.set_bind_group(i, *group, &[]);
            }
            for areas in areas.chunks(MOST_AREAS) {
                computing.set_bind_group(0, &written(pass.gpu(), output, &frame.uniforms, outputs, areas), &[]);
                let tiles = |side: fn(&Region) -> u32| areas.iter().map(side).max().unwrap_or(0).div_ceil(TILE_SIDE);
                computing.dispatch_workgroups(tiles(|area| area.width), tiles(|area| area.height), areas.len() as u32);
            }
        }
    }
}

/// Group 0 of a kernel.
fn written(
    gpu: &GpuDevice,
    output: &Output,
    frame: &wgpu::Buffer,
    outputs: &[&Target],
    areas: &[Region],
) -> wgpu::BindGroup {
    let mut places = [[0; 4]; MOST_AREAS];
    for (place, area) in places.iter_mut().zip(areas) {
        *place = [area.x, area.y, area.width, area.height];
    }
    let areas = uniform(gpu, "areas", bytemuck::cast_slice(&places));
    let textures = outputs.iter().map(|target| target.view.resource());
    output.bind(gpu, &[frame.resource(), areas.resource()].into_iter().chain(textures).collect::<Vec<_>>())
}

fn attachment(target: &Target, load: wgpu::LoadOp<wgpu::Color>) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    Some(wgpu::RenderPassColorAttachment { view: &target.view, depth_slice: None, resolve_target: None, ops })
}

/// A target that is cleared first.
pub fn cleared(target: &Target) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    attachment(target, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT))
}
