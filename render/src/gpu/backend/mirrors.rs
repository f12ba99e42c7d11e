//! Mirrors that show the scene: the hierarchy that their rays traverse, and their passes.

use super::{
    encode::{clear, encode_areas, lattice},
    groups::MirroredGroups,
    picture::Picture,
    progress::Progress,
};
use crate::{
    baked::Baked,
    device::{BoxHierarchy, GpuDevice, layout, storage, uniform},
    error::BackendError,
    gpu::{
        passes::{PartPass, Passes},
        pipeline::Pass,
        targets::Mirrored,
    },
    shade::mirrors::DEEPEST,
    stale::LightPart,
    view::View,
};
use lapidary_core::{ground::Ground, image::Region, offset, opacity::Opacities, ray::Intersector};

/// What the rays of mirrors meet: all triangles, those of thin surfaces too.
pub struct PictureRays {
    pub uniforms: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub corners: wgpu::Buffer,
    pub leaf_triangles: wgpu::Buffer,
    largest_offset: f32,
    /// First triangle of a ground.
    ground: Option<u32>,
}

impl PictureRays {
    /// Of a scene. Which surfaces let light through is for the pass to say.
    ///
    /// # Errors
    /// A hierarchy that the adapter has no room for.
    pub fn new(gpu: &GpuDevice, baked: &Baked) -> Result<Self, BackendError> {
        let mesh = &baked.dataset.scene.mesh;
        let own;
        let intersector = if baked.intersector().has_veils() {
            own = Intersector::quick(mesh, &Opacities::default());
            &own
        } else {
            baked.intersector()
        };
        let BoxHierarchy { nodes, corners } = BoxHierarchy::new(gpu, intersector)?;
        let ids: &[u32] = intersector.leaf_triangle_ids();
        let leaf_triangles =
            storage(gpu, "leaf triangles", bytemuck::cast_slice(if ids.is_empty() { &[0] } else { ids }));
        let uniforms = uniform(gpu, "mirrored scene", &[0; size_of::<layout::MirroredScene>()]);
        let largest_offset = offset::LARGEST * mesh.bounds().diagonal();
        let ground = mesh.ground.map(|start| start.triangle);
        Ok(Self { uniforms, nodes, corners, leaf_triangles, largest_offset, ground })
    }

    /// Takes what a view shows of the ground.
    pub fn set_view(&self, gpu: &GpuDevice, view: &View) {
        let ground = self.ground.unwrap_or(u32::MAX);
        let shows_ground = u32::from(view.ground() != Ground::Off);
        let largest_offset = self.largest_offset;
        let uniforms = layout::MirroredScene { ground, shows_ground, largest_offset, padding: 0 };
        gpu.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
    }
}

/// What encodes the passes of mirrors.
#[derive(Clone, Copy)]
struct Encoding<'e> {
    passes: &'e Passes,
    picture: &'e Picture,
    groups: &'e MirroredGroups,
    targets: &'e Mirrored,
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
        let encoding = Encoding { passes, picture, groups: bound, targets, areas };
        let [sharp, second] = &passes.mirror_rays;
        let seen = (&groups.frame, &sums[from]);
        encoding.rays(encoder, second, 0, seen);
        let last = encoding.light(encoder, (0, AS_BAKED));
        let outputs = [&targets.second];
        encode_areas(
            encoder,
            &passes.second_rays,
            &[&groups.frame, &bound.nothing, &bound.second[last]],
            &outputs,
            areas,
        );
        encoding.rays(encoder, sharp, 0, seen);
        let last = encoding.light_with_mirrors(encoder);
        let first = lattice(stride).map_or(1 - from, |lattice| 2 + lattice);
        let shading = [&groups.frame, &groups.scene, &bound.light[last][first], &sums[from]];
        encode_areas(encoder, &passes.mirrors, &shading, &[&to.value, &to.work], areas);
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
        (frame, seen): (&wgpu::BindGroup, &wgpu::BindGroup),
    ) {
        let Self { passes, groups, areas, .. } = self;
        let (scene, points, targets) =
            (&self.picture.groups.scene, &groups.points[mirrors], &self.targets.points[mirrors]);
        let outputs = [&targets.rays, &targets.weights];
        encode_areas(encoder, rays, &[frame, scene, &groups.nothing, seen], &outputs, areas);
        let outputs = [&targets.geometry, &targets.rotation];
        encode_areas(encoder, &passes.mirrored_surface, &[frame, scene, &points.scene], &outputs, areas);
        let bound = [&groups.frames[mirrors][0], scene, &points.surfaces];
        encode_areas(encoder, &passes.parameters, &bound, &[&targets.color_roughness], areas);
        clear(encoder, &targets.sums[0]);
    }

    /// Light of all kinds from points, by the frames and passes of so many mirrors. Returns which of the sums has it.
    fn light(self, encoder: &mut wgpu::CommandEncoder, (points, passes): (usize, usize)) -> usize {
        let (targets, groups) = (&self.targets.points[points], &self.groups.points[points]);
        let passes = self.picture.mirrored[passes].iter().zip(&self.groups.frames[passes]);
        passes.enumerate().fold(0, |read, (index, (PartPass { pass, light, .. }, frame))| {
            let written = (index + 1) % 2;
            let shading = [frame, &self.picture.groups.scene, light, &groups.shading[read]];
            let sums = &targets.sums[written];
            encode_areas(encoder, pass, &shading, &[&sums.value, &sums.work], self.areas);
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
        let shading = [frame, &picture.groups.scene, &groups.deeper[deeper], &points.shading[read]];
        let sums = &self.targets.points[0].sums[1 - read];
        encode_areas(encoder, &passes.mirrors, &shading, &[&sums.value, &sums.work], areas);
        1 - read
    }
}
