//! The shape of a rectangular light: its position and axes, and its intersection with a ray.

use super::{Emission, Light};
use glam::{Vec2, Vec3};

/// A rectangle in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleShape {
    /// Its center.
    pub center: Vec3,
    /// Horizontal vector from its center to the middle of an edge, half its width.
    pub half_width: Vec3,
    /// Vector from its center to the middle of an edge, half its height.
    pub half_height: Vec3,
    /// Unit normal of the emitting side.
    pub normal: Vec3,
}

/// A direction counts as vertical if its horizontal part is less than this share of its vertical part.
const VERTICAL: f32 = 1e-4;

impl RectangleShape {
    /// The shape of a rectangular light; `None` for other lights, and if target and position coincide.
    pub fn of(light: &Light) -> Option<Self> {
        let Emission::Rectangle { width, height } = light.emission else { return None };
        let normal = light.forward()?;
        let vertical = normal.x.hypot(normal.z) < VERTICAL;
        let right = normal.cross(if vertical { Vec3::Z } else { Vec3::Y }).normalize();
        Some(Self {
            center: light.position,
            half_width: 0.5 * width * right,
            half_height: 0.5 * height * right.cross(normal),
            normal,
        })
    }

    /// Area in m².
    pub fn area(&self) -> f32 {
        4.0 * self.half_width.length() * self.half_height.length()
    }

    /// The four corners, in order around it.
    pub fn corners(&self) -> [Vec3; 4] {
        let (w, h) = (self.half_width, self.half_height);
        [self.center - w - h, self.center + w - h, self.center + w + h, self.center - w + h]
    }

    /// The point at `u` in the unit square.
    pub fn point(&self, u: Vec2) -> Vec3 {
        self.center + self.half_width * (2.0 * u.x - 1.0) + self.half_height * (2.0 * u.y - 1.0)
    }

    /// Distance at which a ray meets the emitting side.
    pub fn intersect(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        let toward = -direction.dot(self.normal);
        let distance = (origin - self.center).dot(self.normal) / toward;
        if !(toward > 0.0 && distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let from_center = origin + direction * distance - self.center;
        let inside = |half: Vec3| from_center.dot(half).abs() <= half.length_squared();
        (inside(self.half_width) && inside(self.half_height)).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facing(target: Vec3) -> RectangleShape {
        let emission = Emission::Rectangle { width: 2.0, height: 1.0 };
        RectangleShape::of(&Light { emission, target, ..Default::default() }).unwrap()
    }

    #[test]
    fn the_width_is_horizontal_and_a_vertical_one_turns_to_z() {
        let tilted = facing(Vec3::new(1.0, -2.0, 0.5));
        assert!(tilted.half_width.y.abs() < 1e-6 && (tilted.half_width.length() - 1.0).abs() < 1e-6);
        assert!(
            tilted.half_width.dot(tilted.normal).abs() < 1e-6 && tilted.half_height.dot(tilted.normal).abs() < 1e-6
        );
        let down = facing(Vec3::NEG_Y);
        assert_eq!((down.half_width.y, down.half_width.z), (0.0, 0.0), "perpendicular to y and z");
        assert!((down.area() - 2.0).abs() < 1e-6);
        assert!(down.corners().iter().all(|c| (c.x.abs() - 1.0).abs() < 1e-6 && (c.z.abs() - 0.5).abs() < 1e-6));
    }

    #[test]
    fn rays_meet_the_side_that_emits_inside_its_edges() {
        let down = facing(Vec3::NEG_Y);
        assert_eq!(down.intersect(Vec3::new(0.9, -3.0, 0.4), Vec3::Y), Some(3.0));
        assert_eq!(down.intersect(Vec3::new(1.1, -3.0, 0.4), Vec3::Y), None, "beside its width");
        assert_eq!(down.intersect(Vec3::new(0.9, -3.0, 0.6), Vec3::Y), None, "beside its height");
        assert_eq!(down.intersect(Vec3::new(0.9, 3.0, 0.4), Vec3::NEG_Y), None, "from behind");
        assert_eq!(down.intersect(Vec3::new(0.9, -3.0, 0.4), Vec3::NEG_Y), None, "away from it");
        assert_eq!(down.intersect(Vec3::new(-3.0, 0.0, 0.0), Vec3::X), None, "in its plane");
    }
}
