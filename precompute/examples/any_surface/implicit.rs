//! The pot: an implicit surface, traced by steps of its distance.

use crate::aggregate::passes;
use glam::{Vec2, Vec3};
use lapidary_core::{
    bounds::Bounds,
    surfel::{MeshPlace, Surface, Surfel},
};

/// Distances below this in meters count as a hit.
const NEAR: f32 = 2e-4;

/// The zero set of a function that bounds the distance to it.
pub struct Implicit {
    distance: fn(Vec3) -> f32,
    bounds: Bounds,
    reflectance: Vec3,
}

impl Implicit {
    /// A ball that blends into the ring below it and the ring around its mouth.
    pub fn pot() -> Self {
        let bounds = Bounds { min: Vec3::new(-0.45, 0.0, -0.75), max: Vec3::new(0.45, 0.75, 0.15) };
        Self { distance: pot, bounds, reflectance: Vec3::new(0.55, 0.38, 0.2) }
    }

    fn normal(&self, at: Vec3) -> Vec3 {
        const STEP: f32 = 1e-3;
        let slope = |axis: Vec3| (self.distance)(at + STEP * axis) - (self.distance)(at - STEP * axis);
        Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(Vec3::Y)
    }
}

fn pot(p: Vec3) -> f32 {
    let p = p - Vec3::new(0.0, 0.0, -0.3);
    let ball = p.distance(Vec3::new(0.0, 0.34, 0.0)) - 0.27;
    let smooth = smooth_minimum(ball, torus(p - Vec3::new(0.0, 0.08, 0.0), 0.2, 0.07), 0.1);
    smooth_minimum(smooth, torus(p - Vec3::new(0.0, 0.6, 0.0), 0.2, 0.05), 0.06)
}

/// Distance to a ring around the vertical.
fn torus(p: Vec3, radius: f32, thickness: f32) -> f32 {
    Vec2::new(Vec2::new(p.x, p.z).length() - radius, p.y).length() - thickness
}

/// The smaller of two distances, rounded where they differ by less than `width`.
fn smooth_minimum(a: f32, b: f32, width: f32) -> f32 {
    let overlap = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - 0.25 * overlap * overlap * width
}

impl Surface for Implicit {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        const MOST_STEPS: usize = 256;
        const FAR: f32 = 10.0;
        let mut distance = 0.0;
        for _ in 0..MOST_STEPS {
            let position = origin + distance * direction;
            let near = (self.distance)(position);
            if near < NEAR {
                return Some(Surfel { position, normal: self.normal(position), place: MeshPlace::default() });
            }
            distance += near;
            if distance > FAR {
                return None;
            }
        }
        None
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        passes(self, from, to)
    }

    fn reflectance(&self, _: &Surfel) -> Vec3 {
        self.reflectance
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Larger than the hit distance: closer rays would end where they started.
    fn offset(&self) -> f32 {
        4.0 * NEAR
    }
}
