//! The lamp: a square under the ceiling that shines downward.

use glam::Vec3;
use lapidary_core::surfel::{Surface, Surfel};

/// Position, half edge and radiance of the square.
pub struct Lamp {
    center: Vec3,
    half: f32,
    radiance: Vec3,
}

impl Default for Lamp {
    fn default() -> Self {
        Self { center: Vec3::new(0.35, 1.98, 0.1), half: 0.2, radiance: Vec3::new(22.0, 20.0, 16.0) }
    }
}

impl Lamp {
    /// Irradiance at a surface point, by a grid of points on the lamp.
    pub fn irradiance(&self, scene: &dyn Surface, at: &Surfel) -> Vec3 {
        const GRID: i32 = 4;
        let from = at.position + at.normal * scene.offset();
        let area = (2.0 * self.half).powi(2) / (GRID * GRID) as f32;
        let mut sum = 0.0;
        for k in 0..GRID * GRID {
            let place = |i: i32| (2.0 * (i as f32 + 0.5) / GRID as f32 - 1.0) * self.half;
            let point = self.center + Vec3::new(place(k % GRID), 0.0, place(k / GRID));
            let toward = point - from;
            let direction = toward.normalize_or_zero();
            let cosines = direction.dot(at.normal).max(0.0) * direction.y.max(0.0);
            if cosines > 0.0 && scene.sees(from, point) {
                sum += cosines * area / toward.length_squared().max(1e-4);
            }
        }
        self.radiance * sum
    }
}
