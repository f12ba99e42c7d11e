//! The map of an environment as sharp lobes read it.

use glam::{Mat3, Quat, Vec3};
use lapidary_core::{
    environment::{Environment, Pyramid},
    simd::Vec3x8,
};
use std::sync::Arc;

/// The map that sharp lobes read, turned and scaled.
#[derive(Clone, Debug)]
pub struct MirroredMap {
    pyramid: Arc<Pyramid>,
    map_from_world: Mat3,
    intensity: f32,
}

impl MirroredMap {
    /// Of a map that is turned by `rotation` radians, counter-clockwise seen from +Y.
    pub fn new(environment: &Environment, rotation: f32, intensity: f32) -> Self {
        let map_from_world = Mat3::from_quat(Quat::from_rotation_y(-rotation));
        Self { pyramid: environment.pyramid(), map_from_world, intensity }
    }

    /// Its levels.
    pub(crate) fn pyramid(&self) -> &Arc<Pyramid> {
        &self.pyramid
    }

    /// Mean radiance over patches of some solid angles around eight unit directions; nothing over none.
    pub(crate) fn radiance_x8(&self, directions: Vec3x8, solid_angles: [f32; 8]) -> [Vec3; 8] {
        let mut radiance = [Vec3::ZERO; 8];
        for (lane, radiance) in radiance.iter_mut().enumerate().filter(|(lane, _)| solid_angles[*lane] > 0.0) {
            let direction = self.map_from_world * directions.lane(lane);
            *radiance = self.pyramid.radiance(direction, solid_angles[lane]) * self.intensity;
        }
        radiance
    }
}
