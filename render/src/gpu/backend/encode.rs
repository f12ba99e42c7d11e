//! The passes of a picture as commands.

use super::GpuBackend;
use crate::{
    BrdfSampling, Post,
    gpu::{frame::frame, layout, passes::MergeVariant, targets::Target},
    view::Background,
};
use std::ops::Range;

impl GpuBackend {
    pub(super) fn write_frame(&self, sample: u32) {
        let picture = self.picture();
        let offset = picture.offsets[sample as usize % picture.offsets.len()];
        let light = self.light.as_ref().map(|(light, _)| light);
        let uniforms = frame(&picture.view, offset, &self.loaded().scene, light);
        self.gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&uniforms));
    }

    pub(super) fn write_display(&self, post: &Post, samples: u32) {
        let picture = self.picture();
        let uniforms = layout::Display {
            exposure: post.exposure.exp2(),
            inv_samples: 1.0 / samples.max(1) as f32,
            count_top: picture.count_top,
            tone_map: post.tone_map as u32,
            view_mode: picture.view.mode as u32,
            transparent: u32::from(picture.view.background == Background::Transparent),
            padding: [0; 2],
        };
        self.gpu.queue.write_buffer(&self.display, 0, bytemuck::bytes_of(&uniforms));
    }

    pub(super) fn encode_visibility(&self, encoder: &mut wgpu::CommandEncoder) {
        let (targets, groups) = (self.targets(), &self.picture().groups);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("visibility"),
            color_attachments: &[cleared(&targets.triangle)],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.passes.visibility);
        pass.set_bind_group(0, &groups.frame, &[]);
        pass.set_bind_group(1, &groups.scene, &[]);
        pass.draw(0..3 * self.loaded().scene.triangle_count, 0..1);
    }

    pub(super) fn encode_deferred(&self, encoder: &mut wgpu::CommandEncoder) {
        let (targets, groups) = (self.targets(), &self.picture().groups);
        let outputs = [&targets.geometry, &targets.rotation];
        let shared = [&groups.frame, &groups.scene, &groups.materials];
        full_screen(encoder, "surface", &self.passes.surface, &outputs, &[&shared[..], &[&groups.triangle]].concat());
        let outputs = [&targets.color_roughness, &targets.others];
        full_screen(
            encoder,
            "parameters",
            &self.passes.parameters,
            &outputs,
            &[&shared[..], &[&groups.geometry]].concat(),
        );
    }

    pub(super) fn encode_merge(&mut self, encoder: &mut wgpu::CommandEncoder, sample: u32, rows: Range<u32>) {
        let variant = self.merge_variant();
        let pipeline = self.passes.merge(&self.gpu, variant).clone();
        let (targets, picture) = (self.targets(), self.picture());
        let (from, to) = ((sample & 1) as usize, (1 - (sample & 1)) as usize);
        if let Some(direct) = &picture.direct {
            direct.encode(encoder, &self.passes.direct, from, &rows);
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("merge"),
            color_attachments: &[kept(&targets.sum[to]), kept(&targets.work[to])],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        let groups = &picture.groups;
        for (i, group) in [&groups.frame, &groups.scene, &groups.light, &groups.merge[from]].into_iter().enumerate() {
            pass.set_bind_group(i as u32, group, &[]);
        }
        pass.set_scissor_rect(0, rows.start, picture.view.size[0], rows.end - rows.start);
        pass.draw(0..3, 0..1);
    }

    pub(super) fn encode_display(&self, encoder: &mut wgpu::CommandEncoder, samples: u32) {
        let group = &self.picture().groups.display[(samples & 1) as usize];
        full_screen(encoder, "display", &self.passes.display, &[&self.targets().shown], &[group]);
    }

    pub(super) fn merge_variant(&self) -> MergeVariant {
        let materials = &self.loaded().materials;
        MergeVariant {
            refine: self.picture().sampling == BrdfSampling::Refine,
            has_ggx: materials.has_ggx,
            has_ward: materials.has_ward,
        }
    }

    pub(super) fn clear_sums(&self, encoder: &mut wgpu::CommandEncoder) {
        let targets = self.targets();
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("clear"),
            color_attachments: &[cleared(&targets.sum[0]), cleared(&targets.work[0])],
            ..Default::default()
        });
    }
}

fn attachment(target: &Target, load: wgpu::LoadOp<wgpu::Color>) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    Some(wgpu::RenderPassColorAttachment { view: &target.view, depth_slice: None, resolve_target: None, ops })
}

fn cleared(target: &Target) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    attachment(target, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT))
}

fn kept(target: &Target) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    attachment(target, wgpu::LoadOp::Load)
}

/// A pass over every pixel.
fn full_screen(
    encoder: &mut wgpu::CommandEncoder,
    label: &str,
    pipeline: &wgpu::RenderPipeline,
    outputs: &[&Target],
    groups: &[&wgpu::BindGroup],
) {
    let attachments: Vec<_> = outputs.iter().map(|t| cleared(t)).collect();
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &attachments,
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    for (i, group) in groups.iter().enumerate() {
        pass.set_bind_group(i as u32, *group, &[]);
    }
    pass.draw(0..3, 0..1);
}
