//! The environment as it is turned and scaled, seen directly.

use crate::renderer::Illumination;
use glam::{Quat, Vec3};

/// Looks up an environment in world space.
pub struct Sky<'a> {
    light: &'a Illumination,
    environment_from_world: Quat,
}

impl<'a> Sky<'a> {
    /// The environment of `light`.
    pub fn new(light: &'a Illumination) -> Self {
        Self { light, environment_from_world: Quat::from_rotation_y(-light.rotation) }
    }

    /// Radiance from a world direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.light.environment.radiance(self.to_environment(direction)) * self.light.intensity
    }

    /// A world direction in the frame of the map.
    pub fn to_environment(&self, direction: Vec3) -> Vec3 {
        self.environment_from_world * direction
    }

    /// A direction of the map in the world.
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.environment_from_world.inverse() * direction
    }
}
