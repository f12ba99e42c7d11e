//! The passes of a picture as commands.

use super::{
    pipelines::Pipelines,
    progress::{Progress, SumState},
};
use crate::{
    device::{layout, uniform},
    gpu::{
        draw::{BoundFrame, bind, cleared, encode_areas, full_screen},
        groups::Kept,
        passes::{PartPass, Passes},
        targets::{Sums, Target},
    },
    stale::{LightPart, Marks, Pixels},
};
use lapidary_core::image::Region;

impl Progress {
    /// What the pixels of a sample see: triangles, marks, surfaces.
    pub fn encode_seen(&mut self, passes: &Passes, encoder: &mut wgpu::CommandEncoder, sample: u32) {
        self.encode_visibility(passes, encoder);
        self.encode_marks(passes, encoder, sample);
        self.encode_deferred(passes, encoder);
    }

    pub fn encode_visibility(&self, passes: &Passes, encoder: &mut wgpu::CommandEncoder) {
        let (targets, picture) = (self.targets(), self.picture());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(passes.visibility.label),
            color_attachments: &[cleared(&targets.triangle)],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        bind(&mut pass, &passes.visibility, &[&picture.groups.frame.group, &picture.groups.scene]);
        pass.draw(0..picture.corners, 0..1);
    }

    pub fn encode_deferred(&self, passes: &Passes, encoder: &mut wgpu::CommandEncoder) {
        let (targets, groups) = (self.targets(), &self.picture().groups);
        let (frame, whole) = (&groups.frame, [Region::whole(targets.size)]);
        let outputs = [&targets.geometry, &targets.rotation];
        encode_areas(encoder, &passes.surface, frame, &[&groups.scene, &groups.seen], &outputs, &whole);
        let outputs = [&targets.color_roughness];
        encode_areas(encoder, &passes.parameters, frame, &[&groups.scene, &groups.surfaces], &outputs, &whole);
    }

    /// What the pixels show of a sample, unless it is known.
    fn encode_marks(&mut self, passes: &Passes, encoder: &mut wgpu::CommandEncoder, sample: u32) {
        let Some(state) = self.state.as_mut().filter(|state| state.marked == sample) else { return };
        let from = state.marks_front;
        (state.marked, state.marks_front) = (sample + 1, 1 - from);
        let groups = &self.picture().groups;
        let bound = [&groups.frame.group, &groups.scene, &groups.patches, &groups.marks[from]];
        full_screen(encoder, &passes.marks, &[&self.targets().marks[1 - from]], &bound);
    }

    /// All passes that add a sample to the sums of the parts of the light, in some areas of the sums or of the lattice with
    /// a stride.
    pub fn encode_parts(&self, passes: &Passes, encoder: &mut wgpu::CommandEncoder, stride: u32, areas: &[Region]) {
        let (picture, from) = (self.picture(), self.state().front);
        let groups = &picture.groups;
        let suns_seen = self.targets().suns_seen.as_ref();
        for pass in &picture.passes {
            let bound = groups.sums[pass.part as usize].as_ref().zip(self.written(pass.part, stride));
            let Some((sums, to)) = bound else { continue };
            encode_part(encoder, pass, &groups.frame, (&groups.scene, &sums[from]), (suns_seen, to), areas);
        }
        self.encode_mirrors(passes, encoder, stride, areas);
    }

    /// Where the passes write a part of the light.
    pub(super) fn written(&self, part: LightPart, stride: u32) -> Option<&Sums> {
        let (targets, back) = (self.targets(), 1 - self.state().front);
        match lattice(stride) {
            None => Some(&targets.parts[part as usize].as_ref()?[back]),
            Some(lattice) => Some(&targets.lattices[part as usize].as_ref()?[lattice]),
        }
    }

    /// Fills between the pixels of the lattice with a stride, in some areas.
    pub fn encode_sketch(&self, passes: &Passes, encoder: &mut wgpu::CommandEncoder, stride: u32, areas: &[Region]) {
        let (groups, front) = (&self.picture().groups, self.state().front);
        for part in LightPart::ALL {
            let bound = groups.sums[part as usize].as_ref().zip(groups.lattices[part as usize].as_ref());
            let Some(((sums, lattices), to)) = bound.zip(self.written(part, 1)) else { continue };
            let Some(lattice) = lattice(stride) else { continue };
            let bound = [&groups.scene, &lattices[lattice], &sums[front]];
            let pass = &passes.sketch[usize::from(part != LightPart::Environment)];
            encode_areas(encoder, pass, &groups.frame, &bound, &[&to.value, &to.work], areas);
        }
    }

    pub fn encode_display(&self, passes: &Passes, encoder: &mut wgpu::CommandEncoder) {
        let group = &self.picture().groups.display[self.shown()];
        full_screen(encoder, &passes.display, &[&self.targets().shown], &[group]);
    }

    /// Drops all samples, and what the pixels show.
    pub fn clear_all(&self, encoder: &mut wgpu::CommandEncoder) {
        let (targets, state) = (self.targets(), self.state());
        targets.parts.iter().flatten().for_each(|sums| clear(encoder, &sums[state.front]));
        clear_targets(encoder, &[&targets.marks[state.marks_front]]);
    }

    /// Moves the sums of all parts to the other of their textures, without the stale `pixels` of each part. `merges_added` tells
    /// that those of the added lights become part of the direct light.
    pub fn encode_kept(
        &mut self,
        pipelines: &Pipelines,
        encoder: &mut wgpu::CommandEncoder,
        pixels: impl Fn(LightPart) -> Pixels,
        merges_added: bool,
    ) {
        let (gpu, passes) = (pipelines.gpu(), &pipelines.passes);
        let (targets, &SumState { front, marks_front, .. }) = (self.targets(), self.state());
        for part in LightPart::ALL {
            let Some(sums) = &targets.parts[part as usize] else { continue };
            let stale = match pixels(part) {
                Pixels::Nothing => Marks::default(),
                Pixels::Showing(marks) => marks,
                Pixels::All => {
                    clear(encoder, &sums[1 - front]);
                    continue;
                }
            };
            let added =
                targets.parts[LightPart::Added as usize].as_ref().filter(|_| merges_added && part == LightPart::Direct);
            let group = Kept {
                stale: &uniform(gpu, "stale marks", bytemuck::bytes_of(&stale_marks(stale))),
                marks: &targets.marks[marks_front].view,
                value: &sums[front].value.view,
                work: &sums[front].work.view,
                added: added.map_or(&targets.nothing.value.view, |sums| &sums[front].value.view),
            };
            let to = &sums[1 - front];
            full_screen(encoder, &passes.keep, &[&to.value, &to.work], &[&group.bind(gpu)]);
        }
        self.flip();
    }
}

/// A pass that adds a sample to the sums of a part of the light, after the rays to suns that it needs. The points are those of the scene
/// with their last sums.
pub(super) fn encode_part(
    encoder: &mut wgpu::CommandEncoder,
    PartPass { pass, light, suns, .. }: &PartPass,
    frame: &BoundFrame,
    (scene, points): (&wgpu::BindGroup, &wgpu::BindGroup),
    (suns_seen, to): (Option<&Target>, &Sums),
    areas: &[Region],
) {
    if let Some(((pass, rays), seen)) = suns.as_ref().zip(suns_seen) {
        encode_areas(encoder, pass, frame, &[scene, rays, points], &[seen], areas);
    }
    encode_areas(encoder, pass, frame, &[scene, light, points], &[&to.value, &to.work], areas);
}

fn stale_marks(Marks { materials, patches }: Marks) -> layout::StaleMarks {
    let words = |bits: u64| [bits as u32, (bits >> 32) as u32];
    layout::StaleMarks { materials: words(materials), patches: words(patches) }
}

pub(super) fn clear(encoder: &mut wgpu::CommandEncoder, sums: &Sums) {
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
pub(super) fn lattice(stride: u32) -> Option<usize> {
    match stride {
        1 => None,
        4 => Some(1),
        _ => Some(0),
    }
}
