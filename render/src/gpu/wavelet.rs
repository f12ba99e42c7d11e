//! Bounced light of wavelet transport. Buffers hold the quads of a dataset and the radiance that arrives at them; they are uploaded
//! when the light changes and not when the camera moves. A pass evaluates them at every pixel.

use super::{groups, meshless::within_limits};
use crate::{
    device::{GpuDevice, layout},
    error::BackendError,
    light::bounce::{PatchLight, Quads},
    remedy::Remedy,
};
use glam::Vec3;
use lapidary_core::wavelet::{patch::Patch, picture::PatchTexture};
use std::sync::Arc;

/// The light of quads as it was last shown.
#[derive(Default)]
pub struct GpuPatches {
    /// The quad of each triangle.
    of_triangles: Option<(Arc<Quads>, wgpu::Buffer)>,
    light: Option<(Arc<PatchLight>, wgpu::BindGroup)>,
}

impl GpuPatches {
    /// Forgets the light, for light that is not shown.
    pub fn forget_light(&mut self) {
        self.light = None;
    }

    /// Uploads missing data, and binds what the pass reads.
    ///
    /// # Errors
    /// Radiance beyond the adapter's limits.
    pub fn bound(&mut self, gpu: &GpuDevice, light: &Arc<PatchLight>) -> Result<wgpu::BindGroup, BackendError> {
        if let Some((_, bound)) = self.light.as_ref().filter(|(known, _)| Arc::ptr_eq(known, light)) {
            return Ok(bound.clone());
        }
        let bound = uploaded(gpu, light, self.of_triangles(gpu, light.quads())?)?;
        self.light = Some((light.clone(), bound.clone()));
        Ok(bound)
    }

    fn of_triangles(&mut self, gpu: &GpuDevice, quads: &Arc<Quads>) -> Result<&wgpu::Buffer, BackendError> {
        let known = self.of_triangles.take().filter(|(known, _)| Arc::ptr_eq(known, quads));
        let make = || {
            let quad_or_none: Vec<u32> = quads.of_triangles.iter().map(|quad| quad.unwrap_or(u32::MAX)).collect();
            let what = "triangles of the wavelet transport";
            Ok((quads.clone(), within_limits(gpu, what, &quad_or_none, Remedy::FewerVertices)?))
        };
        Ok(&self.of_triangles.insert(known.map_or_else(make, Ok)?).1)
    }
}

fn uploaded(
    gpu: &GpuDevice,
    light: &PatchLight,
    quad_of_triangles: &wgpu::Buffer,
) -> Result<wgpu::BindGroup, BackendError> {
    let mut first = 0;
    let quad = |(patch, texture): (&Patch, &PatchTexture)| {
        let quad = quad(patch, texture, first);
        first += texture.radiance().len() as u32;
        quad
    };
    let quads: Vec<_> = light.quads().patches.iter().zip(light.textures()).map(quad).collect();
    let texels = light.textures().iter().flat_map(PatchTexture::radiance);
    let radiance: Vec<[f32; 4]> = texels.map(|radiance| radiance.extend(0.0).to_array()).collect();
    let quads = &within_limits(gpu, "quads of the wavelet transport", &quads, Remedy::Cpu)?;
    let radiance = &within_limits(gpu, "radiance of the wavelet transport", &radiance, Remedy::Cpu)?;
    Ok(groups::QuadLight { quads, quad_of_triangles, radiance }.bind(gpu))
}

fn quad(patch: &Patch, texture: &PatchTexture, first: u32) -> layout::LitQuad {
    let padded = |v: Vec3| v.extend(0.0).to_array();
    let [square_u, square_v] = patch.square_from_offset();
    layout::LitQuad {
        corner: patch.corner.to_array(),
        first,
        square_u: square_u.to_array(),
        side: texture.side(),
        square_v: square_v.to_array(),
        cells: texture.cells().side as u32,
        frame: [patch.frame.x_axis, patch.frame.y_axis, patch.frame.z_axis].map(padded),
    }
}
