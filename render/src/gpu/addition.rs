//! Passes over every pixel that add light to the sum of all samples and passes so far, in an intermediate texture. The
//! next pass adds to that, and the merge to the last. Floats of 32 bits cannot be blended without an optional feature.

use super::{
    device::GpuDevice,
    pipeline::{Layouts, bind},
    scene::GpuScene,
    targets::{Target, Targets, format, target},
};
use lapidary_core::image::Region;
use wgpu::BindingResource::TextureView as View;

/// Inputs of such passes from a picture, whatever light they add.
#[derive(Clone, Copy)]
pub struct PictureInputs<'a> {
    pub gpu: &'a GpuDevice,
    pub layouts: &'a Layouts,
    pub scene: &'a GpuScene,
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
        let geometry = [self.scene.vertices.as_entire_binding(), self.scene.triangles.as_entire_binding()];
        bind(self.gpu, "scene", &self.layouts.scene, &geometry)
    }

    /// The sums of the samples before, by which of them is complete.
    pub fn sums(&self) -> [&wgpu::TextureView; 2] {
        [0, 1].map(|from| &self.targets.complete[from].value.view)
    }
}

/// One pass of a picture.
pub struct Addition {
    /// The sum to add to, and its light.
    pub sum: wgpu::TextureView,
    label: &'static str,
    pipeline: wgpu::RenderPipeline,
    frame: wgpu::BindGroup,
    scene: wgpu::BindGroup,
    light: wgpu::BindGroup,
    /// Indexed by which of the sums is complete.
    inputs: [wgpu::BindGroup; 2],
}

impl Addition {
    /// The pass of `pipeline`, which reads `light` and adds to `previous` (indexed by which of the sums is complete).
    pub fn new(
        picture: &PictureInputs,
        (label, pipeline): (&'static str, &wgpu::RenderPipeline),
        light: wgpu::BindGroup,
        previous: [&wgpu::TextureView; 2],
        sum: &mut SumTexture,
    ) -> Self {
        let Targets { geometry, rotation, color_roughness, others, size, .. } = picture.targets;
        let inputs = |previous: &wgpu::TextureView| {
            let [geometry, rotation, color, others] = [geometry, rotation, color_roughness, others].map(|t| &t.view);
            let inputs = [geometry, rotation, color, others, previous].map(View);
            bind(picture.gpu, label, &picture.layouts.addition, &inputs)
        };
        Self {
            sum: sum.of_size(picture.gpu, *size),
            label,
            pipeline: pipeline.clone(),
            frame: picture.frame_group(),
            scene: picture.scene_group(),
            light,
            inputs: previous.map(inputs),
        }
    }

    /// Adds light to some parts of the sum of all samples so far.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder, from: usize, parts: &[Region]) {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(self.label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.sum,
                depth_slice: None,
                resolve_target: None,
                ops,
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        for (i, group) in [&self.frame, &self.scene, &self.light, &self.inputs[from]].into_iter().enumerate() {
            pass.set_bind_group(i as u32, group, &[]);
        }
        draw_parts(&mut pass, parts);
    }
}

/// Draws some parts of the picture.
pub fn draw_parts(pass: &mut wgpu::RenderPass, parts: &[Region]) {
    for part in parts {
        pass.set_scissor_rect(part.x, part.y, part.width, part.height);
        pass.draw(0..3, 0..1);
    }
}

/// The texture that a pass writes, kept from picture to picture of a size.
#[derive(Default)]
pub struct SumTexture(Option<Target>);

impl SumTexture {
    /// Whether there is one.
    #[cfg(test)]
    pub fn takes_room(&self) -> bool {
        self.0.is_some()
    }

    fn of_size(&mut self, gpu: &GpuDevice, size: [u32; 2]) -> wgpu::TextureView {
        let fits = |t: &Target| [t.texture.width(), t.texture.height()] == size;
        let kept = self.0.take().filter(fits);
        self.0.insert(kept.unwrap_or_else(|| target(gpu, "sum between passes", format::FLOATS, size))).view.clone()
    }
}
