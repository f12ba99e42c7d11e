//! Mirrors that show the scene: their passes.

use super::{
    encode::{clear, encode_part, lattice},
    groups::MirroredGroups,
    picture::Picture,
    progress::Progress,
};
use crate::{
    device::pass::Pass,
    gpu::{
        draw::{BoundFrame, encode_areas},
        passes::Passes,
        targets::{Mirrored, Target},
    },
    shade::mirrors::DEEPEST,
    stale::LightPart,
};
use lapidary_core::image::Region;

/// What encodes the passes of mirrors.
#[derive(Clone, Copy)]
struct Encoding<'e> {
    passes: &'e Passes,
    picture: &'e Picture,
    groups: &'e MirroredGroups,
    targets: &'e Mirrored,
    /// Rays to suns that meet nothing.
    suns_seen: Option<&'e Target>,
    areas: &'e [Region],
}

impl Progress {
    /// The passes that add a sample to the light that mirrors show, as [`Self::encode_parts`] does to the others. Rays of wider lobes
    /// come first, then those of sharp ones, whose points have mirrors, too.
    pub fn encode_mirrors(&self, passes: &Passes, encoder: &mut wgpu::CommandEncoder, stride: u32, areas: &[Region]) {
        let (picture, from) = (self.picture(), self.state().front);
        let groups = &picture.groups;
        let targets = self.targets().mirrored.as_ref().zip(self.written(LightPart::Mirrors, stride));
        let bound = groups.mirrored.as_ref().zip(groups.sums[LightPart::Mirrors as usize].as_ref());
        let Some(((targets, to), (bound, sums))) = targets.zip(bound) else { return };
        let suns_seen = self.targets().suns_seen.as_ref();
        let encoding = Encoding { passes, picture, groups: bound, targets, suns_seen, areas };
        let [sharp, second] = &passes.mirror_rays;
        let seen = (&groups.frame, &sums[from]);
        encoding.rays(encoder, second, 0, seen);
        let last = encoding.light(encoder, (0, AS_BAKED));
        let outputs = [&targets.second];
        encode_areas(
            encoder,
            &passes.second_rays,
            &groups.frame,
            &[&bound.nothing, &bound.second[last]],
            &outputs,
            areas,
        );
        encoding.rays(encoder, sharp, 0, seen);
        let last = encoding.light_with_mirrors(encoder);
        let first = lattice(stride).map_or(1 - from, |lattice| 2 + lattice);
        let shading = [&groups.scene, &bound.light[last][first], &sums[from]];
        encode_areas(encoder, &passes.mirrors, &groups.frame, &shading, &[&to.value, &to.work], areas);
    }
}

/// Which frames and passes show light as baked: those of the last mirror.
const AS_BAKED: usize = DEEPEST as usize - 1;

impl Encoding<'_> {
    /// Rays from what is seen, and the surfaces that they meet, as points within so many mirrors.
    fn rays(
        self,
        encoder: &mut wgpu::CommandEncoder,
        rays: &Pass,
        mirrors: usize,
        (frame, seen): (&BoundFrame, &wgpu::BindGroup),
    ) {
        let Self { passes, groups, areas, .. } = self;
        let (scene, points, targets) =
            (&self.picture.groups.scene, &groups.points[mirrors], &self.targets.points[mirrors]);
        let outputs = [&targets.rays, &targets.weights];
        encode_areas(encoder, rays, frame, &[scene, &groups.nothing, seen], &outputs, areas);
        let outputs = [&targets.geometry, &targets.rotation];
        encode_areas(encoder, &passes.mirrored_surface, frame, &[scene, &points.scene], &outputs, areas);
        let (frame, bound) = (&groups.frames[mirrors][0], [scene, &points.surfaces]);
        encode_areas(encoder, &passes.parameters, frame, &bound, &[&targets.color_roughness], areas);
        clear(encoder, &targets.sums[0]);
    }

    /// Light of all kinds from points, by the frames and passes of so many mirrors. Returns which of the sums has it.
    fn light(self, encoder: &mut wgpu::CommandEncoder, (points, passes): (usize, usize)) -> usize {
        let (targets, groups) = (&self.targets.points[points], &self.groups.points[points]);
        let passes = self.picture.mirrored[passes].iter().zip(&self.groups.frames[passes]);
        passes.enumerate().fold(0, |read, (index, (pass, frame))| {
            let written = (index + 1) % 2;
            let points = (&self.picture.groups.scene, &groups.shading[read]);
            encode_part(encoder, pass, frame, points, (self.suns_seen, &targets.sums[written]), self.areas);
            written
        })
    }

    /// The same of points in one mirror, with what their mirrors show.
    fn light_with_mirrors(self, encoder: &mut wgpu::CommandEncoder) -> usize {
        let Self { passes, picture, groups, areas, .. } = self;
        let [points, _] = &groups.points;
        self.rays(encoder, &passes.mirror_rays[0], 1, (&groups.frames[0][0], &points.shading[0]));
        let deeper = self.light(encoder, (1, AS_BAKED));
        let read = self.light(encoder, (0, 0));
        let frame = &groups.frames[0][picture.mirrored[0].len()];
        let shading = [&picture.groups.scene, &groups.deeper[deeper], &points.shading[read]];
        let sums = &self.targets.points[0].sums[1 - read];
        encode_areas(encoder, &passes.mirrors, frame, &shading, &[&sums.value, &sums.work], areas);
        1 - read
    }
}
