//! The passes of a picture as commands.

use super::GpuBackend;
use crate::{
    gpu::{
        addition::draw_parts,
        frame::frame,
        layout::{
            self,
            constants::{FIELD_ENVIRONMENT, FIELD_NONE, FIELD_SOURCES},
        },
        passes::MergeVariant,
        targets::{Sums, Target},
    },
    post::Post,
    shade::merge::BrdfSampling,
    view::Background,
};
use lapidary_core::image::Region;

impl GpuBackend {
    pub(super) fn write_frame(&self, sample: u32, stride: u32) {
        let picture = self.picture();
        let offset = picture.offsets[sample as usize % picture.offsets.len()];
        let light = self.shown_environment().map(|(light, _)| light);
        let uniforms = frame(&picture.view, offset, &self.loaded().scene, light, stride);
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

    /// The additions before the merges of a sample, and all merges, one after another: each adds to the output of the
    /// one before it. `parts` are texels: with a `stride` above 1 those of the first sample's lattice.
    pub(super) fn encode_merge(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        sample: u32,
        stride: u32,
        parts: &[Region],
    ) {
        let fields = self.fields();
        let complete = (sample & 1) as usize;
        self.picture().additions.iter().for_each(|addition| addition.encode(encoder, complete, parts));
        for (i, &field) in fields.iter().enumerate() {
            let variant = self.merge_variant(field, i == 0);
            let pipeline = self.passes.merge(&self.gpu, variant).clone();
            let groups = &self.picture().groups;
            let from = if i == 0 { &groups.merge_complete[complete] } else { &groups.merge_partial[(i - 1) & 1] };
            let is_last = i + 1 == fields.len();
            let targets = self.targets();
            let to = match lattice(stride) {
                _ if !is_last => &targets.partial[i & 1],
                None => &targets.complete[1 - complete],
                Some(lattice) => &targets.lattices[lattice],
            };
            let light = if field == FIELD_SOURCES { groups.sources.as_ref() } else { Some(&groups.light) };
            let Some(light) = light else { continue };
            let bound = [&groups.frame, &groups.scene, light, from];
            self.encode_parts(encoder, "merge", &pipeline, &bound, to, parts);
        }
    }

    /// The trees of lights that are merged, in order. It is never empty, because the first pass also shows what has no
    /// light.
    fn fields(&self) -> Vec<u32> {
        let first = if self.shown_environment().is_some() { FIELD_ENVIRONMENT } else { FIELD_NONE };
        let sources = self.picture().groups.sources.as_ref().map(|_| FIELD_SOURCES);
        [Some(first), sources].into_iter().flatten().collect()
    }

    fn encode_parts(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        pipeline: &wgpu::RenderPipeline,
        groups: &[&wgpu::BindGroup],
        to: &Sums,
        parts: &[Region],
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[kept(&to.value), kept(&to.work)],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        for (i, group) in groups.iter().enumerate() {
            pass.set_bind_group(i as u32, *group, &[]);
        }
        draw_parts(&mut pass, parts);
    }

    /// Fills the picture between the pixels of the lattice with a stride.
    pub(super) fn encode_sketch(&self, encoder: &mut wgpu::CommandEncoder, stride: u32) {
        let (groups, targets) = (&self.picture().groups, self.targets());
        let Some(from) = lattice(stride) else { return };
        let bound = [&groups.frame, &groups.scene, &groups.light, &groups.sketch[from]];
        let whole = [Region::whole(targets.size)];
        self.encode_parts(encoder, "sketch", &self.passes.sketch, &bound, &targets.complete[0], &whole);
    }

    pub(super) fn encode_display(&self, encoder: &mut wgpu::CommandEncoder, samples: u32) {
        let group = &self.picture().groups.display[(samples & 1) as usize];
        full_screen(encoder, "display", &self.passes.display, &[&self.targets().shown], &[group]);
    }

    fn merge_variant(&self, field: u32, is_first: bool) -> MergeVariant {
        let materials = &self.loaded().materials;
        MergeVariant {
            field,
            is_first,
            refine: self.picture().sampling == BrdfSampling::Refine,
            has_ggx: materials.has_ggx,
            has_ward: materials.has_ward,
        }
    }

    pub(super) fn clear_sums(&self, encoder: &mut wgpu::CommandEncoder) {
        let targets = self.targets();
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("clear"),
            color_attachments: &[cleared(&targets.complete[0].value), cleared(&targets.complete[0].work)],
            ..Default::default()
        });
    }
}

/// Where a lattice lies, if it is not the whole sample.
fn lattice(stride: u32) -> Option<usize> {
    match stride {
        1 => None,
        4 => Some(1),
        _ => Some(0),
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
