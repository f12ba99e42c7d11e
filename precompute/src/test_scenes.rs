//! Test scenes: plain triangles in known places.

use crate::vertices::sidedness::{Sidedness, classify};
use glam::Vec3;
pub use lapidary_core::test_scenes::{cuboid, floor, quad, room, scene_of};
use lapidary_core::{mesh_surface::MeshSurface, ray::Intersector, scene::Scene};

/// A scene with the data that a [`MeshSurface`] borrows.
pub struct Prepared {
    pub scene: Scene,
    pub sides: Sidedness,
    pub intersector: Intersector,
}

impl Prepared {
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let scene = scene_of(triangles);
        Self { sides: classify(&scene), intersector: Intersector::new(&scene.mesh), scene }
    }

    pub fn surface(&self) -> MeshSurface<'_> {
        MeshSurface::new(&self.scene.mesh, &self.intersector, &self.sides.two_sided, &|_| Vec3::splat(0.5))
    }
}
