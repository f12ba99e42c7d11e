//! The passes of a picture as commands.

use super::{GpuBackend, Loaded, SumState};
use crate::{
    device::{
        bind,
        layout::{
            self,
            constants::{FIELD_ENVIRONMENT, FIELD_NONE, FIELD_SOURCES},
        },
    },
    gpu::{
        frame::{Lit, frame},
        passes::MergeVariant,
        targets::{Sums, Target},
    },
    post::Post,
    sampling::BrdfSampling,
    shade::mirror::Mirror,
    stale::{Marks, Part, Pixels},
    view::Background,
};
use lapidary_core::image::Region;
use wgpu::util::DeviceExt;

impl GpuBackend {
    pub(super) fn write_frame(&self, sample: u32, stride: u32) {
        let picture = self.picture();
        let light = self.shown_environment().map(|(light, _)| light);
        let lit = Lit {
            shown: light,
            behind: self.light.as_ref().map(|(light, _)| light),
            emission: self.local.components.direct,
            catches: picture.catches,
        };
        let uniforms = frame(&picture.view, sample, picture.offset(sample), &self.loaded().scene, lit, stride);
        self.gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&uniforms));
    }

    pub(super) fn write_display(&self, post: &Post) {
        let picture = self.picture();
        let uniforms = layout::Display {
            exposure: post.exposure.exp2(),
            count_top: picture.count_top,
            tone_map: post.tone_map as u32,
            view_mode: picture.view.mode as u32,
            transparent: u32::from(picture.view.background == Background::Transparent),
            lets_light_through: u32::from(picture.lets_light_through()),
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
        pass.draw(0..3 * self.loaded().scene.triangles_shown(&self.picture().view), 0..1);
    }

    pub(super) fn encode_deferred(&self, encoder: &mut wgpu::CommandEncoder) {
        let (targets, groups) = (self.targets(), &self.picture().groups);
        let outputs = [&targets.geometry, &targets.rotation];
        let shared = [&groups.frame, &groups.scene];
        full_screen(encoder, "surface", &self.passes.surface, &outputs, &[&shared[..], &[&groups.triangle]].concat());
        let outputs = [&targets.color_roughness];
        full_screen(
            encoder,
            "parameters",
            &self.passes.parameters,
            &outputs,
            &[&shared[..], &[&groups.parameters]].concat(),
        );
    }

    /// What the pixels show of a sample, unless it is known.
    pub(super) fn encode_marks(&mut self, encoder: &mut wgpu::CommandEncoder, sample: u32) {
        let Some(state) = self.state.as_mut().filter(|state| state.marked == sample) else { return };
        let from = state.marks_front;
        (state.marked, state.marks_front) = (sample + 1, 1 - from);
        let groups = &self.picture().groups;
        let bound = [&groups.frame, &groups.scene, &groups.patches, &groups.marks[from]];
        full_screen(encoder, "marks", &self.passes.marks, &[&self.targets().marks[1 - from]], &bound);
    }

    /// All passes that add a sample to the sums of the parts of the light, in some areas of the sums or of the lattice with
    /// a stride.
    pub(super) fn encode_parts(&mut self, encoder: &mut wgpu::CommandEncoder, stride: u32, areas: &[Region]) {
        let from = self.state().front;
        for addition in &self.picture().additions {
            let Some(sums) = self.written(addition.part, stride) else { continue };
            self.encode_areas(encoder, addition.label, &addition.pipeline, &addition.groups(from), sums, areas);
        }
        for (part, field) in self.fields() {
            let variant = self.merge_variant(field, part == Part::Environment);
            let pipeline = self.passes.merge(&self.gpu, variant).clone();
            let groups = &self.picture().groups;
            let light = if field == FIELD_SOURCES { groups.sources.as_ref() } else { Some(&groups.light) };
            let bound = light.zip(groups.sums[part as usize].as_ref());
            let Some(((light, merge), sums)) = bound.zip(self.written(part, stride)) else {
                continue;
            };
            let bound = [&groups.frame, &groups.scene, light, &merge[from]];
            self.encode_areas(encoder, "merge", &pipeline, &bound, sums, areas);
        }
    }

    /// The trees of lights that are merged, by the part of the light. The first part is never missing, because it also
    /// has what has no light.
    fn fields(&self) -> Vec<(Part, u32)> {
        let first = if self.shown_environment().is_some() { FIELD_ENVIRONMENT } else { FIELD_NONE };
        let sources = self.picture().groups.sources.as_ref().map(|_| (Part::Bounce, FIELD_SOURCES));
        [Some((Part::Environment, first)), sources].into_iter().flatten().collect()
    }

    fn encode_areas(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        pipeline: &wgpu::RenderPipeline,
        groups: &[&wgpu::BindGroup],
        to: &Sums,
        areas: &[Region],
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
        for area in areas {
            pass.set_scissor_rect(area.x, area.y, area.width, area.height);
            pass.draw(0..3, 0..1);
        }
    }

    /// Where the passes write a part of the light.
    fn written(&self, part: Part, stride: u32) -> Option<&Sums> {
        let (targets, back) = (self.targets(), 1 - self.state().front);
        match lattice(stride) {
            None => Some(&targets.parts[part as usize].as_ref()?[back]),
            Some(lattice) => Some(&targets.lattices[part as usize].as_ref()?[lattice]),
        }
    }

    /// Fills between the pixels of the lattice with a stride, in some areas.
    pub(super) fn encode_sketch(&self, encoder: &mut wgpu::CommandEncoder, stride: u32, areas: &[Region]) {
        let (groups, front) = (&self.picture().groups, self.state().front);
        for part in Part::ALL {
            let bound = groups.sums[part as usize].as_ref().zip(groups.lattices[part as usize].as_ref());
            let Some(((sums, lattices), to)) = bound.zip(self.written(part, 1)) else { continue };
            let Some(lattice) = lattice(stride) else { continue };
            let bound = [&groups.frame, &groups.scene, &lattices[lattice], &sums[front]];
            let pipeline = &self.passes.sketch[usize::from(part != Part::Environment)];
            self.encode_areas(encoder, "sketch", pipeline, &bound, to, areas);
        }
    }

    pub(super) fn encode_display(&self, encoder: &mut wgpu::CommandEncoder) {
        let group = &self.picture().groups.display[self.shown()];
        full_screen(encoder, "display", &self.passes.display, &[&self.targets().shown], &[group]);
    }

    fn merge_variant(&self, field: u32, is_first: bool) -> MergeVariant {
        let refine = self.picture().sampling != BrdfSampling::Once;
        let may_mirror = |loaded: &Loaded| Mirror::may_be(loaded.materials.narrowest, loaded.scene.leaf_solid_angle);
        MergeVariant {
            field,
            is_first,
            refine,
            mirrors: refine && field == FIELD_ENVIRONMENT && self.scene.as_ref().is_some_and(may_mirror),
            lit: self.picture().sampling == BrdfSampling::Lit,
        }
    }

    /// Drops all samples, and what the pixels show.
    pub(super) fn clear_all(&self, encoder: &mut wgpu::CommandEncoder) {
        let (targets, state) = (self.targets(), self.state());
        targets.parts.iter().flatten().for_each(|sums| clear(encoder, &sums[state.front]));
        clear_targets(encoder, &[&targets.marks[state.marks_front]]);
    }

    /// Moves the sums of all parts to the other of their textures, without what is stale. `added` is the part that is
    /// added to the direct light.
    pub(super) fn encode_kept(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pixels: impl Fn(Part) -> Pixels,
        merges_added: bool,
    ) {
        let (targets, &SumState { front, marks_front, .. }) = (self.targets(), self.state());
        for part in Part::ALL {
            let Some(sums) = &targets.parts[part as usize] else { continue };
            let stale = match pixels(part) {
                Pixels::Nothing => Marks::default(),
                Pixels::Showing(marks) => marks,
                Pixels::All => {
                    clear(encoder, &sums[1 - front]);
                    continue;
                }
            };
            let added = targets.parts[Part::Added as usize].as_ref().filter(|_| merges_added && part == Part::Direct);
            let added = added.map_or(&targets.nothing.value, |sums| &sums[front].value);
            let uniform = self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("stale marks"),
                contents: bytemuck::bytes_of(&stale_marks(stale)),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let inputs = [&targets.marks[marks_front], &sums[front].value, &sums[front].work, added];
            let [marks, value, work, added] = inputs.map(|t| wgpu::BindingResource::TextureView(&t.view));
            let bound = [uniform.as_entire_binding(), marks, value, work, added];
            let group = bind(&self.gpu, "kept sums", &self.passes.layouts.keep, &bound);
            let to = &sums[1 - front];
            full_screen(encoder, "kept sums", &self.passes.keep, &[&to.value, &to.work], &[&group]);
        }
        self.flip();
    }
}

fn stale_marks(Marks { materials, patches }: Marks) -> layout::StaleMarks {
    let words = |bits: u64| [bits as u32, (bits >> 32) as u32];
    layout::StaleMarks { materials: words(materials), patches: words(patches) }
}

fn clear(encoder: &mut wgpu::CommandEncoder, sums: &Sums) {
    clear_targets(encoder, &[&sums.value, &sums.work]);
}

fn clear_targets(encoder: &mut wgpu::CommandEncoder, targets: &[&Target]) {
    let attachments: Vec<_> = targets.iter().map(|target| cleared(target)).collect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("clear"),
        color_attachments: &attachments,
        ..Default::default()
    });
}

/// Which lattice has a stride; `None` for the whole sample.
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
pub(super) fn full_screen(
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
