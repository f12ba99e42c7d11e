//! Points of surfaces under lights that come and go: what an edit does not change is kept.

use super::{
    irradiance::{ShadowRays, light_irradiance},
    light_groups::LightGroups,
};
use crate::{appearance::Appearance, baked::Baked};
use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    lights::Light,
    ray::{Intersector, offset},
    surfel::Surfel,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Points with the direct light on them and their reflectance.
pub(super) struct LitPoints {
    dataset: Arc<Dataset>,
    intersector: Arc<Intersector>,
    pub(super) points: Vec<Surfel>,
    /// Of shading, one a point: the bounce is as bright as the surface that is seen.
    normals: Vec<Vec3>,
    area_samples: u32,
    albedo: Vec<Vec3>,
    /// What local lights give the points.
    pub(super) lights: LightGroups,
    environment: Option<Vec<Vec3>>,
}

impl LitPoints {
    /// Points of a dataset that looks as it was baked, in the dark. Area lights cast so many samples along each of their sides.
    pub fn new(baked: &Baked, points: Vec<Surfel>, area_samples: u32) -> Self {
        let (dataset, intersector) = (baked.dataset.clone(), baked.intersector());
        let (albedo, lights) = (Vec::new(), LightGroups::default());
        let normals = points.par_iter().map(|point| dataset.scene.mesh.shading_normal(point)).collect();
        let mut lit = Self { dataset, intersector, points, normals, area_samples, albedo, lights, environment: None };
        lit.set_appearance(&Appearance::of(&lit.dataset.scene));
        lit
    }

    /// Diffuse reflectance of the points.
    pub fn albedo(&self) -> &[Vec3] {
        &self.albedo
    }

    /// Gives the points the reflectance of other materials; what does not fit looks as in the dataset.
    pub fn set_appearance(&mut self, appearance: &Appearance) {
        let scene = &self.dataset.scene;
        let (fitted, _) = appearance.fitted(&scene.materials);
        self.albedo = self.points.par_iter().map(|p| fitted.albedo(&scene.mesh, p.place)).collect();
    }

    /// Shines local lights on the points, by rays; only for those that are not as before. Returns whether there are
    /// such.
    pub fn set_lights(&mut self, lights: &[Light]) -> bool {
        let rays = ShadowRays { area_samples: self.area_samples, offset: self.ray_offset() };
        self.lights
            .update(lights, |lights| light_irradiance(&self.points, &self.normals, lights, &self.intersector, rays))
    }

    /// Shines an environment on the points that gives each of them so much, or none.
    pub fn set_environment(&mut self, irradiance: Option<Vec<Vec3>>) {
        self.environment = irradiance;
    }

    /// Irradiance in W/m².
    pub fn irradiance(&self) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; self.points.len()];
        for part in self.lights.groups.iter().map(|group| &group.irradiance).chain(&self.environment) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        sum
    }

    /// Distance in metres that shadow rays start off a surface.
    fn ray_offset(&self) -> f32 {
        offset::BOUNCE * self.dataset.scene.mesh.bounds().diagonal()
    }
}
