//! Bounced light of the meshless basis at the vertices. A buffer holds vector irradiance for each side; it is uploaded
//! when the solution changes and not when the camera moves. A pass interpolates it at every pixel.

use super::{
    addition::{Addition, PictureInputs},
    device::GpuDevice,
    layout,
    pipeline::{Binding, Layouts, Pipeline, Shaders, bind, layout as bind_layout, module},
    scene::storage,
    shaders::BOUNCE,
    targets::format,
};
use crate::{backend::BackendError, light::bounce::VertexIrradiance, stale::Part};
use glam::Mat3A;
use std::sync::Arc;

/// The pipeline, with what it reads.
pub struct BouncePass {
    pipeline: wgpu::RenderPipeline,
    irradiance: wgpu::BindGroupLayout,
}

impl BouncePass {
    /// Builds the pipeline.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders, layouts: &Layouts) -> Result<Self, BackendError> {
        let irradiance = bind_layout(gpu, "vertex irradiance", &[Binding::Storage, Binding::Storage]);
        let pipeline = Pipeline {
            layouts: &[&layouts.frame, &layouts.scene, &irradiance, &layouts.addition],
            targets: &format::SUMS,
            ..Pipeline::new(module(gpu, shaders, &BOUNCE)?, "bounce")
        };
        Ok(Self { pipeline: pipeline.build(gpu), irradiance })
    }
}

/// Bounced light at the vertices as it was last shown.
#[derive(Default)]
pub struct VertexBounce {
    uploaded: Option<(Arc<VertexIrradiance>, [wgpu::Buffer; 2])>,
}

impl VertexBounce {
    /// Uploads missing data, and binds the resources of a picture.
    pub fn prepare(
        &mut self,
        picture: &PictureInputs,
        pass: &BouncePass,
        vertices: &Arc<VertexIrradiance>,
    ) -> Option<Addition> {
        let known = self.uploaded.take().filter(|(known, _)| Arc::ptr_eq(known, vertices));
        let make = || (vertices.clone(), [&vertices.front, &vertices.back].map(|side| upload(picture.gpu, side)));
        let (_, buffers) = self.uploaded.insert(known.unwrap_or_else(make));
        let sides = buffers.each_ref().map(|side| side.as_entire_binding());
        let light = bind(picture.gpu, "vertex irradiance", &pass.irradiance, &sides);
        Addition::new(picture, ("bounce", &pass.pipeline), light, Part::Bounce)
    }

    /// Input of the pass, to detect a new upload.
    #[cfg(test)]
    pub fn buffer(&self) -> Option<&wgpu::Buffer> {
        self.uploaded.as_ref().map(|(_, [front, _])| front)
    }
}

/// A vertex takes less room than in the buffer of the mesh, whose size is within the limits. There is always one,
/// because buffers cannot be empty.
fn upload(gpu: &GpuDevice, vertices: &[Mat3A]) -> wgpu::Buffer {
    const { assert!(size_of::<layout::VertexIrradiance>() <= size_of::<layout::Vertex>()) };
    let padded = |v: &Mat3A| layout::VertexIrradiance { vector: v.to_cols_array_2d().map(|[x, y, z]| [x, y, z, 0.0]) };
    let contents: Vec<_> = vertices.iter().chain(vertices.is_empty().then_some(&Mat3A::ZERO)).map(padded).collect();
    storage(gpu, "vertex irradiance", bytemuck::cast_slice(&contents))
}
