//! A mesh that carries functions: as baked, and where its objects are now.

use super::MeshSurface;
use crate::{
    bounds::Bounds,
    mesh::Mesh,
    meshless::{Carrier, Owner, RayEnd},
    ray::{Fan, FanDevice, Hit},
    surfel::{Surface, Surfel},
};
use glam::Vec3;
use rayon::prelude::*;

/// A posed mesh with its baked one: the same triangles with other corners.
#[derive(Clone, Copy)]
pub struct CarryingMesh<'a> {
    as_baked: &'a Mesh,
    now: MeshSurface<'a>,
    device: Option<&'a dyn FanDevice>,
}

impl<'a> CarryingMesh<'a> {
    /// `now` is the surface of the posed mesh.
    pub fn new(as_baked: &'a Mesh, now: MeshSurface<'a>) -> Self {
        Self { as_baked, now, device: None }
    }

    /// The same with rays of fans traced on a device that has the posed mesh.
    #[must_use]
    pub fn on_device(self, device: Option<&'a dyn FanDevice>) -> Self {
        Self { device, ..self }
    }

    fn end(&self, hit: Option<Hit>) -> RayEnd {
        let Some(hit) = hit else { return RayEnd::Sky };
        match self.now.seen(hit) {
            Some(at) => RayEnd::Surface(at),
            None => RayEnd::Dark(self.now.mesh.surfel(hit.triangle, hit.barycentric, hit.back_face)),
        }
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
        let hits = self.now.intersector.closest_hits(origin, directions);
        hits.into_iter().map(|eight| eight.map(|hit| self.end(hit))).collect()
    }

    fn traces_fans(&self) -> bool {
        self.device.is_some()
    }

    fn ends_of_fans(&self, fans: &[Fan], directions: &[Vec3]) -> Option<Vec<RayEnd>> {
        let hits = self.device?.first_hits(fans).ok()?;
        let ends = hits.into_par_iter().enumerate().map(|(ray, hit)| {
            let fan = &fans[ray / directions.len()];
            let direction = || fan.frame * directions[ray % directions.len()];
            let rays = self.now.intersector;
            self.end(if rays.has_veils() { rays.with_thin_surfaces(hit, fan.origin, direction()) } else { hit })
        });
        Some(ends.collect())
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
