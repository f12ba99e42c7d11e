//! Surface points under changing lights, with stored results that an edit does not change.

use super::{
    irradiance::{ShadowRays, light_irradiance},
    light_groups::LightGroups,
};
use crate::{
    appearance::{Appearance, ResolvedAppearance},
    baked::Baked,
    light::situation::Changes,
};
use glam::Vec3;
use lapidary_core::{lights::Light, offset, ray::spatial_order, scene::Mesh, surfel::Surfel};
use rayon::prelude::*;

/// Points with their direct light and reflectance.
pub(crate) struct LitPoints {
    baked: Baked,
    pub(super) points: Vec<Surfel>,
    /// Point indices in the order of ray casting.
    order: Vec<u32>,
    /// Shading normals, one per point: the bounce is then as bright as the visible surface.
    normals: Vec<Vec3>,
    area_samples: u32,
    albedo: Vec<Vec3>,
    emission: Vec<Vec3>,
    /// Irradiance of the points from local lights.
    pub(super) lights: LightGroups,
    /// Irradiance of the points from the environment.
    pub(super) environment: Option<Vec<Vec3>>,
}

impl LitPoints {
    /// Points of a dataset with the baked materials and no light. Area lights cast `area_samples` rays along each side.
    pub fn new(baked: &Baked, points: Vec<Surfel>, area_samples: u32) -> Self {
        let dataset = baked.dataset.clone();
        let (albedo, emission, lights) = (Vec::new(), Vec::new(), LightGroups::default());
        let normals = points.par_iter().map(|point| dataset.scene.mesh.shading_normal(point)).collect();
        let order = (0..points.len() as u32).collect();
        let (baked, environment) = (baked.clone(), None);
        let mut lit = Self { baked, points, order, normals, area_samples, albedo, emission, lights, environment };
        lit.take_appearance(&Appearance::of(&dataset.scene));
        lit
    }

    /// Casts rays in spatial order. Use it for points whose own order is not spatial.
    #[must_use]
    pub fn in_spatial_order(self) -> Self {
        let positions: Vec<Vec3> = self.points.iter().map(|point| point.position).collect();
        Self { order: spatial_order(&positions), ..self }
    }

    /// Moves the points to the posed scene and removes their light.
    pub fn pose(&mut self, posed: &Baked, points: Vec<Surfel>) {
        self.normals = points.par_iter().map(|point| posed.dataset.scene.mesh.shading_normal(point)).collect();
        (self.baked, self.points) = (posed.clone(), points);
        (self.lights, self.environment) = (LightGroups::default(), None);
    }

    /// The points where they are now.
    pub fn points(&self) -> &[Surfel] {
        &self.points
    }

    /// The mesh that they lie on, where it is now.
    pub fn mesh(&self) -> &Mesh {
        &self.baked.dataset.scene.mesh
    }

    /// Diffuse reflectance of the points.
    pub fn albedo(&self) -> &[Vec3] {
        &self.albedo
    }

    /// Radiance in W/(m² sr) that the points emit.
    pub fn emission(&self) -> &[Vec3] {
        &self.emission
    }

    /// Updates materials and lights. Casts rays only for changed lights.
    pub fn update(&mut self, appearance: &Appearance, lights: &[Light], changes: Changes) {
        if changes.appearance {
            self.take_appearance(appearance);
        }
        let rays = ShadowRays { area_samples: self.area_samples, offset: self.ray_offset() };
        self.lights.update(lights, |lights| {
            light_irradiance(&self.points, &self.normals, &self.order, lights, (self.baked.intersector(), rays))
        });
    }

    fn take_appearance(&mut self, appearance: &Appearance) {
        let scene = &self.baked.dataset.scene;
        let appearance = ResolvedAppearance::from(appearance.clone());
        let points = self.points.par_iter().map(|point| appearance.albedo_and_emission(&scene.mesh, point.place));
        (self.albedo, self.emission) = points.unzip();
    }

    /// Irradiance in W/m².
    pub fn irradiance(&self) -> Vec<Vec3> {
        self.sum(self.lights.groups.iter().map(|group| &group.irradiance).chain(&self.environment))
    }

    /// Irradiance from local lights and suns in W/m².
    pub(super) fn of_lamps(&self) -> Vec<Vec3> {
        self.sum(self.lights.groups.iter().map(|group| &group.irradiance))
    }

    fn sum<'a>(&self, parts: impl Iterator<Item = &'a Vec<Vec3>>) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; self.points.len()];
        for part in parts {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        sum
    }

    /// Distance in meters of shadow ray origins from the surface.
    fn ray_offset(&self) -> f32 {
        offset::BOUNCE * self.baked.dataset.scene.mesh.bounds().diagonal()
    }
}
