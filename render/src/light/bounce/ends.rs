//! Where rays of surface points end, in a scene as baked.

use crate::baked::Baked;
use glam::Vec3;
use lapidary_core::{
    mesh_surface::{CarryingMesh, MeshSurface},
    meshless::{Carrier, RayEnd},
    offset,
    ray::in_eights,
    surfel::Surfel,
};

/// Rays that start at surface points.
pub struct SurfaceRays<'a> {
    surface: CarryingMesh<'a>,
    /// Distance of their origins from the surface in meters.
    lift: f32,
}

impl<'a> SurfaceRays<'a> {
    /// Rays in a scene.
    pub fn new(baked: &'a Baked) -> Self {
        // Nothing asks for reflectances.
        const BLACK: &(dyn Fn(&Surfel) -> Vec3 + Sync) = &|_| Vec3::ZERO;
        let (dataset, mesh) = (&baked.dataset, &baked.dataset.scene.mesh);
        let surface = MeshSurface::new(mesh, baked.intersector(), &dataset.two_sided, BLACK);
        Self { surface: CarryingMesh::new(mesh, surface), lift: offset::TRANSPORT * mesh.bounds().diagonal() }
    }

    /// The ends of rays from a point. The number of unit directions is a multiple of eight.
    pub fn ends(&self, at: &Surfel, directions: &[Vec3]) -> Vec<RayEnd> {
        let eights = in_eights(directions.iter().copied());
        self.surface.ends(at.position + at.normal * self.lift, &eights).into_flattened()
    }
}
