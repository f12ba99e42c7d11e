//! Passes over every pixel, beside the merge, that add to the sums of a part of the light.

use super::{
    materials::GpuMaterials,
    pipeline::Layouts,
    scene::GpuScene,
    targets::{Sums, Targets},
};
use crate::{
    device::{GpuDevice, bind},
    stale::Part,
};
use wgpu::BindingResource::TextureView as View;

/// Inputs of such passes from a picture, whatever light they add.
#[derive(Clone, Copy)]
pub struct PictureInputs<'a> {
    pub gpu: &'a GpuDevice,
    pub layouts: &'a Layouts,
    pub scene: &'a GpuScene,
    pub materials: &'a GpuMaterials,
    pub frame: &'a wgpu::Buffer,
    pub targets: &'a Targets,
}

impl PictureInputs<'_> {
    /// The group of the frame.
    pub fn frame_group(&self) -> wgpu::BindGroup {
        bind(self.gpu, "frame", &self.layouts.frame, &[self.frame.as_entire_binding()])
    }

    /// The group of the scene.
    pub fn scene_group(&self) -> wgpu::BindGroup {
        self.materials.bound_with(self.gpu, &self.layouts.scene, self.scene)
    }
}

/// One pass of a picture.
pub struct Addition {
    /// The part of the light whose sums it adds to.
    pub part: Part,
    pub label: &'static str,
    pub pipeline: wgpu::RenderPipeline,
    frame: wgpu::BindGroup,
    scene: wgpu::BindGroup,
    light: wgpu::BindGroup,
    /// Indexed by which of the sums is read.
    inputs: [wgpu::BindGroup; 2],
}

impl Addition {
    /// The pass of `pipeline`, which reads `light` and adds to a part that the picture has; `None` if it has not.
    pub fn new(
        picture: &PictureInputs,
        (label, pipeline): (&'static str, &wgpu::RenderPipeline),
        light: wgpu::BindGroup,
        part: Part,
    ) -> Option<Self> {
        let Targets { geometry, rotation, color_roughness, parts, .. } = picture.targets;
        let inputs = |sums: &Sums| {
            let inputs = [geometry, rotation, color_roughness, &sums.value, &sums.work].map(|t| View(&t.view));
            bind(picture.gpu, label, &picture.layouts.addition, &inputs)
        };
        Some(Self {
            part,
            label,
            pipeline: pipeline.clone(),
            frame: picture.frame_group(),
            scene: picture.scene_group(),
            light,
            inputs: parts[part as usize].as_ref()?.each_ref().map(inputs),
        })
    }

    /// Its inputs, with one of the sums.
    pub fn groups(&self, from: usize) -> [&wgpu::BindGroup; 4] {
        [&self.frame, &self.scene, &self.light, &self.inputs[from]]
    }
}
