//! What the passes of a picture read, bound: each group as `gpu/groups.rs` declares it.

use super::{pipelines::Uniforms, progress::Progress, shown::Shown};
use crate::{
    device::GpuDevice,
    gpu::{
        groups::{Display, Frame, Lattice, Marks, Patches, Scene, Seen, Shading, Surfaces},
        targets::{Sums, Targets},
    },
    stale::LightPart,
};
use wgpu::BindGroup;

/// Everything that the passes of a picture read, but what some add alone.
pub struct Groups {
    pub frame: BindGroup,
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
}

impl Groups {
    /// Those of a picture whose light is uploaded and whose targets are made.
    pub fn new(gpu: &GpuDevice, uniforms: &Uniforms, shown: &Shown, progress: &Progress) -> Self {
        let (loaded, targets) = (shown.loaded(), progress.targets());
        let Targets { triangle, geometry, parts, .. } = targets;
        let [triangle_ids, geometry] = [&triangle.view, &geometry.view];
        let marks = |from: usize| Marks { triangle_ids, previous_marks: &targets.marks[from].view }.bind(gpu);
        let shading = |from: &Sums| shading(gpu, targets, from, shown);
        Self {
            frame: Frame { frame: &uniforms.frame }.bind(gpu),
            scene: scene(gpu, shown),
            seen: Seen { triangle_ids }.bind(gpu),
            surfaces: Surfaces { geometry, environment_map: shown.map() }.bind(gpu),
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
        }
    }
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

/// Points to shade, with some sums.
fn shading(gpu: &GpuDevice, targets: &Targets, from: &Sums, shown: &Shown) -> BindGroup {
    // Without levels no pass reads any.
    let mirrored = shown.merged_environment().0.mirrored.as_ref();
    let group = Shading {
        geometry: &targets.geometry.view,
        rotation: &targets.rotation.view,
        color_roughness: &targets.color_roughness.view,
        previous_value: &from.value.view,
        previous_work: &from.work.view,
        environment_map: shown.map(),
        mirrored_map: mirrored.map_or(shown.map(), |mirrored| &mirrored.view),
    };
    group.bind(gpu)
}

/// The sums of all parts; a texel of zeros for those that the light lacks.
fn display(gpu: &GpuDevice, uniforms: &Uniforms, targets: &Targets, front: usize) -> BindGroup {
    let sums = targets.parts.each_ref().map(|part| part.as_ref().map_or(&targets.nothing, |sums| &sums[front]));
    let [environment, bounce, direct, added] = sums.map(|sums| (&sums.value.view, &sums.work.view));
    let group = Display {
        display: &uniforms.display,
        magma_stops: &uniforms.magma,
        environment_value: environment.0,
        environment_work: environment.1,
        bounce_value: bounce.0,
        bounce_work: bounce.1,
        direct_value: direct.0,
        direct_work: direct.1,
        added_value: added.0,
        added_work: added.1,
    };
    group.bind(gpu)
}
