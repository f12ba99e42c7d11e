//! A mesh that carries functions: as baked, and where its objects are now.

use super::MeshSurface;
use crate::{
    bounds::Bounds,
    mesh::Mesh,
    meshless::{Carrier, Owner, RayEnd},
    ray::Hit,
    surfel::{Surface, Surfel},
};
use glam::Vec3;

/// A posed mesh with its baked one: the same triangles with other corners.
#[derive(Clone, Copy)]
pub struct CarryingMesh<'a> {
    as_baked: &'a Mesh,
    now: MeshSurface<'a>,
}

impl<'a> CarryingMesh<'a> {
    /// `now` is the surface of the posed mesh.
    pub fn new(as_baked: &'a Mesh, now: MeshSurface<'a>) -> Self {
        Self { as_baked, now }
    }
}

impl Surface for CarryingMesh<'_> {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        self.now.first_hit(origin, direction)
    }

    fn first_hits(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[Option<Surfel>; 8]> {
        self.now.first_hits(origin, directions)
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        self.now.sees(from, to)
    }

    fn reflectance(&self, at: &Surfel) -> Vec3 {
        self.now.reflectance(at)
    }

    fn bounds(&self) -> Bounds {
        self.now.bounds
    }
}

impl Carrier for CarryingMesh<'_> {
    fn ends(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[RayEnd; 8]> {
        let end = |hit: Option<Hit>| match hit {
            None => RayEnd::Sky,
            Some(hit) => match self.now.seen(hit) {
                Some(at) => RayEnd::Surface(at),
                None => RayEnd::Dark(self.now.mesh.surfel(hit.triangle, hit.barycentric, hit.back_face)),
            },
        };
        self.now.intersector.closest_hits(origin, directions).into_iter().map(|eight| eight.map(end)).collect()
    }

    fn owner(&self, at: &Surfel) -> Owner {
        self.now.owner(at)
    }

    fn as_baked(&self, at: &Surfel) -> Surfel {
        self.as_baked.surfel(at.place.triangle, at.place.barycentric, self.owner(at).back)
    }

    fn now(&self, as_baked: &Surfel) -> Surfel {
        let back = Owner::on(self.as_baked, as_baked).back;
        self.now.mesh.surfel(as_baked.place.triangle, as_baked.place.barycentric, back)
    }

    fn shading_normal(&self, at: &Surfel) -> Vec3 {
        self.now.mesh.shading_normal(at)
    }
}
