//! Points of surfaces under lights that come and go: what an edit does not change is kept.

use super::irradiance::light_irradiance;
use crate::{appearance::Appearance, baked::Baked};
use glam::Vec3;
use lapidary_core::{dataset::Dataset, lights::Light, ray::Intersector, surfel::Surfel};
use rayon::prelude::*;
use std::sync::Arc;

/// Most groups of lights whose irradiance is kept apart; each takes 12 bytes a point.
pub(super) const LIGHT_GROUPS: usize = 64;

/// Points with the direct light on them and their reflectance.
pub(super) struct LitPoints {
    dataset: Arc<Dataset>,
    intersector: Arc<Intersector>,
    points: Vec<Surfel>,
    albedo: Vec<Vec3>,
    /// Lights with the irradiance that they give the points, visibility included.
    pub(super) groups: Vec<(Vec<Light>, Vec<Vec3>)>,
    environment: Option<Vec<Vec3>>,
}

impl LitPoints {
    /// Points of a dataset that looks as it was baked, in the dark.
    pub fn new(baked: &Baked, points: Vec<Surfel>) -> Self {
        let (dataset, intersector) = (baked.dataset.clone(), baked.intersector());
        let (albedo, groups) = (Vec::new(), Vec::new());
        let mut lit = Self { dataset, intersector, points, albedo, groups, environment: None };
        lit.set_appearance(&Appearance::of(&lit.dataset.scene));
        lit
    }

    pub fn points(&self) -> &[Surfel] {
        &self.points
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

    /// Shines local lights on the points, by rays; only for those that are not as before.
    pub fn set_lights(&mut self, lights: &[Light]) {
        let lit: Vec<Light> = lights.iter().filter(|l| l.enabled).cloned().collect();
        let mut before = std::mem::take(&mut self.groups);
        let group = |lights: &[Light]| match before.iter().position(|(known, _)| known == lights) {
            Some(i) => before.swap_remove(i),
            None => (lights.to_vec(), light_irradiance(&self.points, lights, &self.intersector, self.ray_offset())),
        };
        self.groups = lit.chunks(lit.len().div_ceil(LIGHT_GROUPS).max(1)).map(group).collect();
    }

    /// Shines an environment on the points that gives each of them so much, or none.
    pub fn set_environment(&mut self, irradiance: Option<Vec<Vec3>>) {
        self.environment = irradiance;
    }

    /// Irradiance in W/m².
    pub fn irradiance(&self) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; self.points.len()];
        for part in self.groups.iter().map(|(_, part)| part).chain(&self.environment) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        sum
    }

    /// Distance in metres that shadow rays start off a surface.
    fn ray_offset(&self) -> f32 {
        1e-4 * self.dataset.scene.mesh.bounds().diagonal()
    }
}
