//! The map of an environment as sharp lobes read it.

use glam::{Mat3, Quat, Vec3};
use lapidary_core::{
    environment::{Environment, Pyramid},
    simd::Vec3x8,
};
use std::sync::Arc;

/// The rotated and scaled map that sharp lobes read.
#[derive(Clone, Debug)]
pub struct MirroredMap {
    pyramid: Arc<Pyramid>,
    map_from_world: Mat3,
    intensity: f32,
}

impl MirroredMap {
    /// Prepares a map rotated by `rotation` radians, counter-clockwise seen from +Y.
    pub fn new(environment: &Environment, rotation: f32, intensity: f32) -> Self {
        let map_from_world = Mat3::from_quat(Quat::from_rotation_y(-rotation));
        Self { pyramid: environment.pyramid(), map_from_world, intensity }
    }

    /// Levels of the map.
    pub(crate) fn pyramid(&self) -> &Arc<Pyramid> {
        &self.pyramid
    }

    /// Mean radiance over patches of these solid angles around eight unit directions; zero for an empty patch.
    pub(crate) fn radiance_x8(&self, directions: Vec3x8, solid_angles: [f32; 8]) -> [Vec3; 8] {
        let mut radiance = [Vec3::ZERO; 8];
        for (lane, radiance) in radiance.iter_mut().enumerate().filter(|(lane, _)| solid_angles[*lane] > 0.0) {
            let direction = self.map_from_world * directions.lane(lane);
            *radiance = self.pyramid.radiance(direction, solid_angles[lane]) * self.intensity;
        }
        radiance
    }
}
