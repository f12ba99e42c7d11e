//! What rays of pictures meet: of mirrors, and to suns.

use crate::{
    baked::Baked,
    device::{BoxHierarchy, GpuDevice, SharedDevice, layout, storage, uniform},
    error::BackendError,
    view::View,
};
use lapidary_core::{ground::Ground, offset, opacity::Opacities, ray::Intersector};
use std::sync::Arc;

/// What rays meet: all triangles, those of thin surfaces too.
pub struct PictureRays {
    pub uniforms: wgpu::Buffer,
    pub hierarchy: Arc<BoxHierarchy>,
    pub leaf_triangles: wgpu::Buffer,
    /// Of rays from their surface, in meters.
    pub largest_offset: f32,
    /// First triangle of a ground.
    ground: Option<u32>,
}

impl PictureRays {
    /// Of a scene. Which surfaces let light through is for the pass to say.
    ///
    /// # Errors
    /// A hierarchy that the adapter has no room for.
    pub fn new(device: &SharedDevice, baked: &Baked) -> Result<Self, BackendError> {
        let mesh = &baked.dataset.scene.mesh;
        let own;
        let intersector = if baked.intersector().has_veils() {
            own = Intersector::quick(mesh, &Opacities::default());
            &own
        } else {
            baked.intersector()
        };
        let (gpu, hierarchy) = (&device.gpu, device.hierarchy(intersector)?);
        let ids: &[u32] = intersector.leaf_triangle_ids();
        let leaf_triangles =
            storage(gpu, "leaf triangles", bytemuck::cast_slice(if ids.is_empty() { &[0] } else { ids }));
        let uniforms = uniform(gpu, "mirrored scene", &[0; size_of::<layout::MirroredScene>()]);
        let largest_offset = offset::LARGEST * mesh.bounds().diagonal();
        let ground = mesh.ground.map(|start| start.triangle);
        Ok(Self { uniforms, hierarchy, leaf_triangles, largest_offset, ground })
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
