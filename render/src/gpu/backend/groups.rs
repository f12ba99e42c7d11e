//! Bind groups of the passes of a picture.

use super::{GpuBackend, Loaded};
use crate::{
    device::bind,
    gpu::{
        light::{GpuLight, GpuTreeLight},
        scene::GpuCuts,
        targets::{Sums, Targets},
    },
    stale::Part,
};

/// Everything the passes of a picture read.
pub struct Groups {
    pub frame: wgpu::BindGroup,
    pub scene: wgpu::BindGroup,
    pub light: wgpu::BindGroup,
    pub triangle: wgpu::BindGroup,
    pub parameters: wgpu::BindGroup,
    /// Surface sources, if their light is shown.
    pub sources: Option<wgpu::BindGroup>,
    pub patches: wgpu::BindGroup,
    /// Indexed by which of the marks is read.
    pub marks: [wgpu::BindGroup; 2],
    /// Indexed by which of the sums is read.
    pub display: [wgpu::BindGroup; 2],
    /// Surfaces, with the sums of each part that the light has, indexed by which of them is read; and their lattices.
    pub sums: [Option<[wgpu::BindGroup; 2]>; Part::COUNT],
    pub lattices: [Option<[wgpu::BindGroup; 2]>; Part::COUNT],
}

impl GpuBackend {
    /// Binds what the passes of a picture read.
    pub(super) fn groups(
        &self,
        loaded: &Loaded,
        light: &GpuLight,
        map: &wgpu::TextureView,
        targets: &Targets,
    ) -> Groups {
        use wgpu::BindingResource::TextureView as View;
        let layouts = &self.passes.layouts;
        let group = |label, layout, resources: &[wgpu::BindingResource]| bind(&self.gpu, label, layout, resources);
        let (scene, materials) = (&loaded.scene, &loaded.materials);
        // Without levels the pass reads none.
        let mirrored = light.mirrored.as_ref().map_or(map, |mirrored| &mirrored.view);
        let merge = |from: &Sums| {
            let inputs = [
                View(&targets.geometry.view),
                View(&targets.rotation.view),
                View(&targets.color_roughness.view),
                View(&from.value.view),
                View(&from.work.view),
                View(map),
                View(mirrored),
            ];
            group("merge", &layouts.merge, &inputs)
        };
        let display = |front: usize| {
            let sums = targets.parts.iter().map(|part| part.as_ref().map_or(&targets.nothing, |sums| &sums[front]));
            let sums = sums.flat_map(|sums| [View(&sums.value.view), View(&sums.work.view)]);
            let uniforms = [self.display.as_entire_binding(), self.magma.as_entire_binding()];
            group("display", &layouts.display, &uniforms.into_iter().chain(sums).collect::<Vec<_>>())
        };
        let lattice = |part: Part, sums: &Sums| {
            let predicted = self.history.as_ref().and_then(|history| history.predicted(part));
            let predicted = predicted.unwrap_or(&targets.nothing.value);
            let inputs = [View(&sums.value.view), View(&sums.work.view), View(&predicted.view)];
            group("lattice", &layouts.lattice, &inputs)
        };
        let marks = |from: usize| {
            group("marks", &layouts.marks, &[View(&targets.triangle.view), View(&targets.marks[from].view)])
        };
        let lit = |label, tree: &GpuTreeLight, cuts: &GpuCuts| {
            let inputs = [
                tree.nodes.as_entire_binding(),
                tree.brightness.as_entire_binding(),
                View(&cuts.view),
                View(&tree.cut),
                tree.lit.nodes.as_entire_binding(),
                tree.lit.offsets.as_entire_binding(),
            ];
            group(label, &layouts.light, &inputs)
        };
        let sources = self.sources.as_ref().zip(scene.sources.as_ref());
        Groups {
            frame: group("frame", &layouts.frame, &[self.frame.as_entire_binding()]),
            scene: materials.bound_with(&self.gpu, &layouts.scene, scene),
            light: lit("light", &light.tree, &scene.cuts),
            triangle: group("triangle", &layouts.ids, &[View(&targets.triangle.view)]),
            parameters: group("parameters", &layouts.parameters, &[View(&targets.geometry.view), View(map)]),
            sources: sources.map(|(light, baked)| lit("sources", &light.tree, &baked.cuts)),
            patches: group("patches", &layouts.patches, &[loaded.patches.as_entire_binding()]),
            marks: [0, 1].map(marks),
            display: [0, 1].map(display),
            sums: Part::ALL.map(|part| targets.parts[part as usize].as_ref().map(|sums| sums.each_ref().map(merge))),
            lattices: Part::ALL.map(|part| {
                let lattices = targets.lattices[part as usize].as_ref();
                lattices.map(|lattices| lattices.each_ref().map(|sums| lattice(part, sums)))
            }),
        }
    }
}
