//! Surface points under changing lights, with stored results that an edit does not change.

use super::{
    irradiance::{ReceivingPoints, ShadowRays, light_irradiance},
    light_groups::LightGroups,
};
use crate::{
    appearance::{Appearance, ResolvedAppearance},
    baked::Baked,
    device::{Compute, GpuShadowRays},
    light::situation::Changes,
};
use glam::Vec3;
use lapidary_core::{
    implicit::{Lighting, Sky},
    lights::Light,
    offset,
    ray::{HierarchyNumber, spatial_order},
    scene::Mesh,
    surfel::Surfel,
};
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
    /// The scene on a device that traces rays to lights.
    on_device: Option<GpuShadowRays>,
    /// A scene that the device did not take.
    refused: Option<HierarchyNumber>,
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
        let mut lit = Self {
            baked: baked.clone(),
            points,
            order,
            normals,
            area_samples,
            on_device: None,
            refused: None,
            albedo,
            emission,
            lights,
            environment: None,
        };
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
    pub fn update(&mut self, (appearance, lights): (&Appearance, &[Light]), compute: &Compute, changes: Changes) {
        if changes.appearance {
            self.take_appearance(appearance);
        }
        let was_there = self.is_on_device();
        self.take_to(compute, lights);
        // All light is by the same rays.
        if self.is_on_device() != was_there {
            self.lights = LightGroups::default();
        }
        let at = ReceivingPoints { points: &self.points, normals: &self.normals, order: &self.order };
        let (offset, area_samples) = (self.ray_offset(), self.area_samples);
        let (baked, device) = (&self.baked, self.on_device.as_ref());
        // The hierarchy is built once a light needs it.
        let rays = || ShadowRays { intersector: baked.intersector(), device, area_samples, offset };
        self.lights.update(lights, |lights| light_irradiance(&at, lights, rays()));
    }

    /// Whether a device traces the rays to lights.
    pub fn is_on_device(&self) -> bool {
        self.on_device.as_ref().is_some_and(GpuShadowRays::works)
    }

    /// Takes the scene to a device, unless it is there. The cores trace what it does not take: thin surfaces, and what has no room.
    fn take_to(&mut self, compute: &Compute, lights: &[Light]) {
        let known = self.on_device.take();
        let Compute::Device(device) = compute else { return };
        if lights.is_empty() {
            return;
        }
        let scene = self.baked.intersector();
        if scene.has_veils() || self.refused == Some(scene.number()) {
            return;
        }
        let known = known.filter(|known| known.is_of(device, scene));
        self.on_device = known.or_else(|| GpuShadowRays::new(device, scene).ok());
        self.refused = self.on_device.is_none().then(|| scene.number());
    }

    fn take_appearance(&mut self, appearance: &Appearance) {
        let scene = &self.baked.dataset.scene;
        let appearance = ResolvedAppearance::from(appearance.clone());
        let points = self.points.par_iter().map(|point| appearance.albedo_and_emission(&scene.mesh, point.place));
        (self.albedo, self.emission) = points.unzip();
    }

    /// The points as leaves of a forest that receive their [`Self::irradiance`] and light of a sky.
    pub fn lighting<'a>(&'a self, received: &'a [Vec3], sky: Sky<'a>) -> Lighting<'a> {
        Lighting { reflectance: &self.albedo, emitted: &self.emission, received, sky }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        device::test_adapter::{on_adapter, shared_device},
        test_scenes::{dataset, light, mesh, point_light, white},
    };
    use lapidary_core::{implicit::forest::SurfelForest, lights::Emission};

    #[test]
    fn a_device_finds_the_irradiance_of_the_cores() {
        let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
        let baked = Baked::from(dataset(mesh(4, true), white()));
        let of = &baked.dataset;
        let forest = SurfelForest::new(&of.scene.mesh, &of.two_sided, 2048);
        let area = Emission::Rectangle { width: 0.8, height: 0.6 };
        let lights = [
            point_light(Vec3::new(0.3, 3.0, 0.2), 3.0),
            light(area, Vec3::new(-0.5, 2.5, 0.4), Vec3::ZERO, 2.0),
            light(Emission::PARALLEL, Vec3::new(0.4, 1.0, 0.3), Vec3::ZERO, 1.0),
        ];
        let under = |compute: &Compute, lights: &[Light]| {
            let mut lit = LitPoints::new(&baked, forest.surfels().collect(), 2);
            lit.update((&Appearance::of(&of.scene), lights), compute, Changes::ALL);
            assert_eq!(lit.is_on_device(), matches!(compute, Compute::Device(_)), "it takes a small scene");
            lit.irradiance()
        };
        let (cores, device) = (Compute::Cores, Compute::Device(device));
        let expected = under(&cores, &lights);
        let differing = |found: &[Vec3]| found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        // Rays along an edge may fall to either side.
        let ties = differing(&under(&device, &lights));
        assert!(ties * 500 <= expected.len(), "{ties} of {}", expected.len());
        // The lights shine, and some points are in the shadow of one of them.
        for (i, other) in lights.iter().enumerate() {
            let without: Vec<Light> = lights.iter().filter(|light| *light != other).cloned().collect();
            let differ = differing(&under(&device, &without));
            assert!(differ > expected.len() / 4 && differ < expected.len(), "negative control: {differ} without {i}");
        }
    }
}
