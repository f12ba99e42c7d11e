//! Bind groups of the passes of a picture.

use super::{GpuBackend, Loaded};
use crate::gpu::{
    addition::Addition,
    light::GpuLight,
    pipeline::bind,
    targets::{Sums, Targets},
};

/// Everything the passes of a picture read.
pub struct Groups {
    pub frame: wgpu::BindGroup,
    pub scene: wgpu::BindGroup,
    pub materials: wgpu::BindGroup,
    pub light: wgpu::BindGroup,
    pub triangle: wgpu::BindGroup,
    pub geometry: wgpu::BindGroup,
    /// Surface sources, if their light is shown.
    pub sources: Option<wgpu::BindGroup>,
    /// Indexed by which of the sums is read.
    pub merge_complete: [wgpu::BindGroup; 2],
    pub merge_partial: [wgpu::BindGroup; 2],
    /// Indexed as the lattices.
    pub sketch: [wgpu::BindGroup; 2],
    pub display: [wgpu::BindGroup; 2],
}

impl GpuBackend {
    /// Binds what the passes of a picture read.
    pub(super) fn groups(
        &self,
        loaded: &Loaded,
        light: &GpuLight,
        map: &wgpu::TextureView,
        targets: &Targets,
        last: Option<&Addition>,
    ) -> Groups {
        use wgpu::BindingResource::TextureView as View;
        let layouts = &self.passes.layouts;
        let group = |label, layout, resources: &[wgpu::BindingResource]| bind(&self.gpu, label, layout, resources);
        let (scene, materials) = (&loaded.scene, &loaded.materials);
        let merge = |from: &Sums, sum: Option<&wgpu::TextureView>| {
            let inputs = [
                View(&targets.geometry.view),
                View(&targets.rotation.view),
                View(&targets.color_roughness.view),
                View(&targets.others.view),
                View(sum.unwrap_or(&from.value.view)),
                View(&from.work.view),
                View(map),
            ];
            group("merge", &layouts.merge, &inputs)
        };
        let display = |from: &Sums| {
            let (sum, work) = (View(&from.value.view), View(&from.work.view));
            let inputs = [self.display.as_entire_binding(), self.magma.as_entire_binding(), sum, work];
            group("display", &layouts.display, &inputs)
        };
        let geometry = [scene.vertices.as_entire_binding(), scene.triangles.as_entire_binding()];
        let pool = View(&materials.pool.view);
        let look = [materials.buffer.as_entire_binding(), pool, materials.linear_from_srgb.as_entire_binding()];
        let lit = [
            light.nodes.as_entire_binding(),
            light.tan_half_radius.as_entire_binding(),
            View(&scene.cuts),
            View(&light.cut),
        ];
        Groups {
            frame: group("frame", &layouts.frame, &[self.frame.as_entire_binding()]),
            scene: group("scene", &layouts.scene, &geometry),
            materials: group("materials", &layouts.materials, &look),
            light: group("light", &layouts.light, &lit),
            triangle: group("triangle", &layouts.ids, &[View(&targets.triangle.view)]),
            geometry: group("geometry", &layouts.ids, &[View(&targets.geometry.view)]),
            sources: self.sources.as_ref().zip(scene.sources.as_ref()).map(|(lit, baked)| {
                // Radii of sources are seen from each point: there is no table of them.
                let tan_half_radius = light.tan_half_radius.as_entire_binding();
                let sent = [lit.nodes.as_entire_binding(), tan_half_radius, View(&baked.cuts), View(&lit.cut)];
                group("sources", &layouts.light, &sent)
            }),
            merge_complete: [0, 1].map(|i| merge(&targets.complete[i], last.map(|addition| &addition.sum))),
            merge_partial: [0, 1].map(|i| merge(&targets.partial[i], None)),
            sketch: [0, 1].map(|i| merge(&targets.lattices[i], None)),
            display: [display(&targets.complete[0]), display(&targets.complete[1])],
        }
    }
}
