//! The environment as it is turned and scaled, seen directly, and what else may stand behind a scene.

use crate::{renderer::Illumination, view::Background};
use glam::{Quat, Vec3};
use lapidary_core::environment::Environment;
use std::borrow::Cow;

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

/// What is seen where there is no surface.
pub enum Backdrop<'a> {
    /// The environment, sharp or blurred.
    Map {
        /// Turn and intensity.
        sky: Sky<'a>,
        /// What is looked up.
        map: Cow<'a, Environment>,
    },
    /// One radiance.
    Flat(Vec3),
}

impl<'a> Backdrop<'a> {
    /// For one picture.
    pub fn new(background: Background, light: &'a Illumination) -> Self {
        let sky = Sky::new(light);
        match background {
            Background::Environment => Self::Map { sky, map: Cow::Borrowed(&light.environment) },
            Background::Blurred(width) => Self::Map { sky, map: Cow::Owned(light.environment.blurred(width)) },
            Background::Flat(radiance) => Self::Flat(radiance),
            Background::Transparent => Self::Flat(Vec3::ZERO),
        }
    }

    /// Radiance from a world direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Map { sky, map } => map.radiance(sky.to_environment(direction)) * sky.light.intensity,
            Self::Flat(radiance) => *radiance,
        }
    }
}
