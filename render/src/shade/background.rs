//! The environment with rotation and intensity, as the background, and other backgrounds.

use crate::{
    light::environment::Illumination,
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::{Quat, Vec3};
use lapidary_core::environment::Environment;
use std::sync::Arc;

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

/// The background where there is no surface.
pub enum Backdrop {
    /// The environment, sharp or blurred.
    Map {
        /// The map.
        map: Arc<Environment>,
        /// Turns world directions into the frame of the map.
        environment_from_world: Quat,
        /// Scales its radiance.
        intensity: f32,
    },
    /// One radiance.
    Flat(Vec3),
}

impl Backdrop {
    /// For one picture without an environment.
    pub fn unlit(view: &View) -> Self {
        match view.background {
            Background::Flat(radiance) if view.mode == ViewMode::Shaded => Self::Flat(radiance),
            _ => Self::black(),
        }
    }

    /// For one picture. View modes that show quantities other than radiance have a black background.
    pub fn new(view: &View, light: &Illumination, blur: &mut BlurCache) -> Self {
        let map = |map| {
            let environment_from_world = Sky::new(light).environment_from_world;
            Self::Map { map, environment_from_world, intensity: light.intensity }
        };
        match view.background {
            _ if view.mode != ViewMode::Shaded => Self::black(),
            Background::Environment => map(light.environment.clone()),
            Background::Blurred(width) => map(blur.blurred(&light.environment, width)),
            Background::Flat(radiance) => Self::Flat(radiance),
            Background::Transparent => Self::black(),
        }
    }

    /// Nothing at all.
    pub fn black() -> Self {
        Self::Flat(Vec3::ZERO)
    }

    /// Radiance from a world direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Map { map, environment_from_world, intensity } => {
                map.radiance(*environment_from_world * direction) * *intensity
            }
            Self::Flat(radiance) => *radiance,
        }
    }
}

/// Keeps a blurred environment until another environment or width is asked for, because blurring takes longer than a
/// frame.
#[derive(Default)]
pub struct BlurCache(Option<Blurred>);

struct Blurred {
    source: Arc<Environment>,
    width: f32,
    map: Arc<Environment>,
}

impl BlurCache {
    /// `source` blurred by a standard deviation of `width` radians.
    pub fn blurred(&mut self, source: &Arc<Environment>, width: f32) -> Arc<Environment> {
        let known = self.0.take().filter(|b| Arc::ptr_eq(&b.source, source) && b.width == width);
        let blur = || Blurred { source: source.clone(), width, map: source.blurred(width).into() };
        self.0.insert(known.unwrap_or_else(blur)).map.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::image::Image;

    #[test]
    fn a_blurred_map_is_kept_until_map_or_width_change() {
        let environment = |value| Arc::new(Environment::new("e".into(), Image::filled([8, 4], value)));
        let (a, b) = (environment(Vec3::ONE), environment(Vec3::splat(2.0)));
        let mut cache = BlurCache::default();
        let first = cache.blurred(&a, 0.2);
        assert!(Arc::ptr_eq(&first, &cache.blurred(&a, 0.2)));
        let wider = cache.blurred(&a, 0.3);
        assert!(!Arc::ptr_eq(&first, &wider));
        let other = cache.blurred(&b, 0.3);
        assert!(!Arc::ptr_eq(&wider, &other) && (other.radiance(Vec3::Z).x - 2.0).abs() < 1e-4);
    }
}
