//! What the passes of a picture read, bound: each group as `gpu/groups.rs` declares it.

use super::{
    pipelines::{MirroredFrames, Uniforms},
    progress::Progress,
    shown::Shown,
};
use crate::{
    device::{GpuDevice, GroupLayout},
    gpu::{
        draw::BoundFrame,
        groups::{
            Display, Lattice, Marks, MirroredLight, MirroredScene, Patches, Scene, SecondLight, Seen, Shading, Surfaces,
        },
        picture_rays::PictureRays,
        targets::{Mirrored, MirroredPoints, Sums, Target, Targets},
    },
    shade::mirrors::DEEPEST,
    stale::LightPart,
};
use std::array::from_fn;
use wgpu::{BindGroup, TextureView};

/// Everything that the passes of a picture read, but what some add alone.
pub struct Groups {
    pub frame: BoundFrame,
    pub scene: BindGroup,
    pub seen: BindGroup,
    pub surfaces: BindGroup,
    pub patches: BindGroup,
    /// Indexed by which of the marks is read.
    pub marks: [BindGroup; 2],
    /// Indexed by which of the sums is read.
    pub display: [BindGroup; 2],
    /// Points to shade, with the sums of each part that the light has, indexed by which of them is read; and their lattices.
    pub sums: [Option<[BindGroup; 2]>; LightPart::COUNT],
    pub lattices: [Option<[BindGroup; 2]>; LightPart::COUNT],
    /// Where mirrors show the scene.
    pub mirrored: Option<MirroredGroups>,
}

/// What the passes of mirrors read.
pub struct MirroredGroups {
    pub frames: MirroredFrames<BoundFrame>,
    pub nothing: BindGroup,
    /// Of one mirror, and of a mirror in it.
    pub points: [MirroredPointGroups; DEEPEST as usize],
    /// The sums of points, by where the first part of the mirrors' own light is: its two sums and its lattices.
    pub light: [[BindGroup; 4]; 2],
    /// The same sums for the rays of wider lobes.
    pub second: [BindGroup; 2],
    /// The sums of points in a mirror in a mirror.
    pub deeper: [BindGroup; 2],
}

/// What the passes read of points that mirrors show.
pub struct MirroredPointGroups {
    pub scene: BindGroup,
    pub surfaces: BindGroup,
    /// Indexed by which of the sums is read.
    pub shading: [BindGroup; 2],
}

impl Groups {
    /// Those of a picture whose light is uploaded and whose targets are made.
    pub fn new(gpu: &GpuDevice, uniforms: &Uniforms, shown: &Shown, progress: &Progress) -> Self {
        let (loaded, targets) = (shown.loaded(), progress.targets());
        let Targets { triangle, geometry, parts, .. } = targets;
        let [triangle_ids, geometry] = [&triangle.view, &geometry.view];
        let mirror_rays = &targets.nothing.value.view;
        let marks = |from: usize| Marks { triangle_ids, previous_marks: &targets.marks[from].view }.bind(gpu);
        let seen = SeenTargets {
            geometry,
            rotation: &targets.rotation.view,
            color_roughness: &targets.color_roughness.view,
            mirror_rays,
        };
        let shading = |from: &Sums| shading(gpu, &seen, from, shown);
        let mirrored = targets.mirrored.as_ref().zip(loaded.rays.as_ref());
        Self {
            frame: BoundFrame::new(gpu, &uniforms.frame),
            scene: scene(gpu, shown),
            seen: Seen { triangle_ids }.bind(gpu),
            surfaces: Surfaces { geometry, environment_map: shown.map(), mirror_rays }.bind(gpu),
            patches: Patches { patches: &loaded.patches }.bind(gpu),
            marks: [0, 1].map(marks),
            display: [0, 1].map(|front| display(gpu, uniforms, targets, front)),
            sums: parts.each_ref().map(|sums| sums.as_ref().map(|sums| sums.each_ref().map(shading))),
            lattices: LightPart::ALL.map(|part| {
                let predicted = progress.history.as_ref().and_then(|history| history.predicted(part));
                let predicted = &predicted.unwrap_or(&targets.nothing.value).view;
                let lattice = |sums: &Sums| {
                    Lattice { lattice_value: &sums.value.view, lattice_work: &sums.work.view, predicted }.bind(gpu)
                };
                targets.lattices[part as usize].as_ref().map(|lattices| lattices.each_ref().map(lattice))
            }),
            mirrored: mirrored
                .map(|(mirrored, rays)| MirroredGroups::new(gpu, uniforms, shown, (targets, mirrored, rays))),
        }
    }
}

impl MirroredGroups {
    fn new(
        gpu: &GpuDevice,
        uniforms: &Uniforms,
        shown: &Shown,
        (targets, mirrored, rays): (&Targets, &Mirrored, &PictureRays),
    ) -> Self {
        let first = [&targets.parts, &targets.lattices].map(|sums| &sums[LightPart::Environment as usize]);
        let first = from_fn::<_, 4, _>(|i| first[i / 2].as_ref().map_or(&targets.nothing, |sums| &sums[i % 2]));
        let [points, deeper] = &mirrored.points;
        let (nothing, second) = (&targets.nothing, &mirrored.second);
        let in_second = |sums: &Sums| {
            let (mirror_weights, mirrored_value) = (&points.weights.view, &sums.value.view);
            SecondLight { mirror_weights, mirrored_value, mirrored_geometry: &points.geometry.view }.bind(gpu)
        };
        Self {
            frames: uniforms
                .mirrored
                .each_ref()
                .map(|frames| frames.each_ref().map(|frame| BoundFrame::new(gpu, frame))),
            nothing: GroupLayout::EMPTY.bind(gpu, &[]),
            points: [(points, &targets.geometry), (deeper, &points.geometry)]
                .map(|(points, from)| MirroredPointGroups::new(gpu, shown, (points, from, rays))),
            light: points
                .sums
                .each_ref()
                .map(|sums| first.map(|first| mirrored_light(gpu, points, sums, first, second))),
            second: points.sums.each_ref().map(in_second),
            deeper: deeper.sums.each_ref().map(|sums| mirrored_light(gpu, deeper, sums, nothing, &nothing.value)),
        }
    }
}

impl MirroredPointGroups {
    /// Of points that rays from others meet.
    fn new(gpu: &GpuDevice, shown: &Shown, (points, from, rays): (&MirroredPoints, &Target, &PictureRays)) -> Self {
        let [geometry, mirror_rays] = [&points.geometry.view, &points.rays.view];
        let seen = SeenTargets {
            geometry,
            rotation: &points.rotation.view,
            color_roughness: &points.color_roughness.view,
            mirror_rays,
        };
        let scene = MirroredScene {
            mirrored: &rays.uniforms,
            nodes: &rays.hierarchy.nodes,
            corners: &rays.hierarchy.corners,
            leaf_triangles: &rays.leaf_triangles,
            geometry: &from.view,
            mirror_rays,
            mirror_weights: &points.weights.view,
        };
        Self {
            scene: scene.bind(gpu),
            surfaces: Surfaces { geometry, environment_map: shown.map(), mirror_rays }.bind(gpu),
            shading: points.sums.each_ref().map(|sums| shading(gpu, &seen, sums, shown)),
        }
    }
}

/// Sums of points, with those of the first part of the light of what shows them, and light of second rays.
fn mirrored_light(
    gpu: &GpuDevice,
    points: &MirroredPoints,
    sums: &Sums,
    environment: &Sums,
    second: &Target,
) -> BindGroup {
    let group = MirroredLight {
        mirror_weights: &points.weights.view,
        mirrored_value: &sums.value.view,
        mirrored_geometry: &points.geometry.view,
        environment_value: &environment.value.view,
        environment_work: &environment.work.view,
        second_value: &second.view,
    };
    group.bind(gpu)
}

fn scene(gpu: &GpuDevice, shown: &Shown) -> BindGroup {
    let (scene, materials) = (&shown.loaded().scene, &shown.loaded().materials);
    let group = Scene {
        vertices: &scene.vertices,
        triangles: &scene.triangles,
        materials: &materials.buffer,
        pool: &materials.pool.view,
        tables: &materials.tables,
        measured: &materials.measured.buffer,
        posed: &scene.posed,
    };
    group.bind(gpu)
}

/// Where points to shade are.
struct SeenTargets<'a> {
    geometry: &'a TextureView,
    rotation: &'a TextureView,
    color_roughness: &'a TextureView,
    mirror_rays: &'a TextureView,
}

/// Points to shade, with some sums.
fn shading(gpu: &GpuDevice, seen: &SeenTargets, from: &Sums, shown: &Shown) -> BindGroup {
    // Without levels no pass reads any.
    let mirrored = shown.merged_environment().0.mirrored.as_ref();
    let group = Shading {
        geometry: seen.geometry,
        rotation: seen.rotation,
        color_roughness: seen.color_roughness,
        previous_value: &from.value.view,
        previous_work: &from.work.view,
        environment_map: shown.map(),
        mirrored_map: mirrored.map_or(shown.map(), |mirrored| &mirrored.view),
        mirror_rays: seen.mirror_rays,
    };
    group.bind(gpu)
}

/// The sums of all parts; a texel of zeros for those that the light lacks.
fn display(gpu: &GpuDevice, uniforms: &Uniforms, targets: &Targets, front: usize) -> BindGroup {
    let sums = targets.parts.each_ref().map(|part| part.as_ref().map_or(&targets.nothing, |sums| &sums[front]));
    let [environment, bounce, mirrors, direct, added] = sums.map(|sums| (&sums.value.view, &sums.work.view));
    let group = Display {
        display: &uniforms.display,
        magma_stops: &uniforms.magma,
        environment_value: environment.0,
        environment_work: environment.1,
        bounce_value: bounce.0,
        bounce_work: bounce.1,
        mirrors_value: mirrors.0,
        mirrors_work: mirrors.1,
        direct_value: direct.0,
        direct_work: direct.1,
        added_value: added.0,
        added_work: added.1,
    };
    group.bind(gpu)
}
