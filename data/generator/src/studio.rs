//! A photographer's studio: soft boxes in a dark room.

use glam::{Vec2, Vec3, vec2, vec3};

use crate::environment::Environment;
use crate::noise::{lerp, smoothstep};

/// A rectangular soft box far away.
struct SoftBox {
    /// Direction of its center.
    towards: Vec3,
    /// Half width and half height as tangents.
    half: Vec2,
    /// Rotation around its own direction, degrees.
    roll: f32,
    /// Radiance at its center.
    radiance: Vec3,
    /// Width of the soft edge, as a fraction of the half size.
    feather: f32,
}

/// The studio map: key from the left, a rim strip from the right, a large weak fill, a small hard spot.
pub fn studio() -> Environment {
    let boxes = soft_boxes();
    let lit = |d: Vec3| boxes.iter().fold(room(d), |sum, soft_box| sum + soft_box.radiance(d));
    let mut map = Environment::paint(lit);
    // A snooted spot beside the key: the only light here with a sharp shadow.
    map.add_disc(vec3(-0.80, 0.58, -0.05).normalize(), 1.6f32.to_radians(), vec3(2.2, 2.0, 1.7));
    map.scaled_to_mean(0.7)
}

fn soft_boxes() -> Vec<SoftBox> {
    let neutral = vec3(1.0, 0.97, 0.93);
    vec![
        SoftBox {
            towards: vec3(-0.66, 0.62, 0.46),
            half: vec2(0.26, 0.36),
            roll: 8.0,
            radiance: neutral * 15.0,
            feather: 0.10,
        },
        SoftBox {
            towards: vec3(0.93, 0.42, -0.16),
            half: vec2(0.085, 0.55),
            roll: -6.0,
            radiance: vec3(0.86, 0.94, 1.0) * 11.0,
            feather: 0.12,
        },
        SoftBox {
            towards: vec3(0.62, 0.30, 0.78),
            half: vec2(0.60, 0.50),
            roll: 0.0,
            radiance: vec3(1.0, 0.93, 0.86) * 0.8,
            feather: 0.40,
        },
        SoftBox {
            towards: vec3(0.12, 1.0, -0.22),
            half: vec2(0.55, 0.14),
            roll: 4.0,
            radiance: neutral * 2.4,
            feather: 0.15,
        },
    ]
}

/// The dark room: a floor with a pool of light, and walls that fade upward.
fn room(d: Vec3) -> Vec3 {
    let cool = vec3(0.92, 0.97, 1.05);
    if d.y >= 0.0 {
        return cool * lerp(0.075, 0.03, smoothstep(0.0, 0.8, d.y));
    }
    let pool = smoothstep(0.0, 1.0, -d.y);
    vec3(1.04, 1.0, 0.95) * lerp(0.075, 0.15, pool)
}

impl SoftBox {
    fn radiance(&self, d: Vec3) -> Vec3 {
        let forward = self.towards.normalize();
        let depth = d.dot(forward);
        if depth <= 0.0 {
            return Vec3::ZERO;
        }
        let right = Vec3::Y.cross(forward).normalize();
        let up = forward.cross(right);
        let plane = vec2(d.dot(right), d.dot(up)) / depth;
        let at = Vec2::from_angle(-self.roll.to_radians()).rotate(plane) / self.half;
        let edge = |x: f32| 1.0 - smoothstep(1.0 - self.feather, 1.0 + self.feather, x.abs());
        // The lamp behind the cloth shows as a hotter middle.
        let hot = lerp(0.72, 1.0, (-1.3 * at.length_squared()).exp());
        self.radiance * (edge(at.x) * edge(at.y) * hot)
    }
}
