//! From world space to points of the viewport and back.

use egui::{Pos2, Rect, vec2};
use glam::{Vec2, Vec3};
use lapidary_core::camera::{self, Camera};

/// Near plane, as a share of the distance to the target.
const NEAR: f32 = 1e-3;

/// How a camera shows the world in a rectangle.
#[derive(Clone, Debug)]
pub struct Projection {
    rect: Rect,
    /// In points of the rectangle.
    of_camera: camera::Projection,
    near: f32,
}

impl Projection {
    /// The projection of `camera` in `rect`.
    pub fn new(camera: &Camera, rect: Rect) -> Self {
        let size = rect.size().max(vec2(1.0, 1.0));
        let of_camera = camera::Projection::new(camera, Vec2::new(size.x, size.y));
        Self { rect, of_camera, near: NEAR * camera.eye.distance(camera.target) }
    }

    /// The eye.
    pub fn eye(&self) -> Vec3 {
        self.of_camera.eye
    }

    /// The unit direction of the optical axis.
    pub fn forward(&self) -> Vec3 {
        self.of_camera.forward()
    }

    /// Depth of a point in meters.
    pub fn depth(&self, world: Vec3) -> f32 {
        self.of_camera.depth(world)
    }

    /// Projects a point; `None` behind the eye.
    pub fn point(&self, world: Vec3) -> Option<Pos2> {
        let view = self.view(world);
        (-view.z > self.near).then(|| self.project(view)).filter(|p| p.is_finite())
    }

    /// Projects the visible part of a line.
    pub fn segment(&self, a: Vec3, b: Vec3) -> Option<[Pos2; 2]> {
        let (a, b) = (self.view(a), self.view(b));
        let ahead = |v: Vec3| -v.z - self.near;
        let crossing = || a.lerp(b, ahead(a) / (ahead(a) - ahead(b)));
        let clipped = match (ahead(a) > 0.0, ahead(b) > 0.0) {
            (true, true) => [a, b],
            (true, false) => [a, crossing()],
            (false, true) => [crossing(), b],
            (false, false) => return None,
        };
        // A crossing rounded to the eye would project to infinity.
        let seen = clipped.map(|view| self.project(Vec3 { z: view.z.min(-0.5 * self.near), ..view }));
        seen.iter().all(|p| p.is_finite()).then_some(seen)
    }

    /// Meters per point of the screen at the depth of `world`; `None` behind the eye.
    pub fn metres_per_point(&self, world: Vec3) -> Option<f32> {
        let depth = -self.view(world).z;
        (depth > self.near).then(|| self.of_camera.pixel_span(depth))
    }

    /// Unit direction of the ray through a position of the screen.
    pub fn direction(&self, pointer: Pos2) -> Vec3 {
        let at = pointer - self.rect.min;
        self.of_camera.ray(Vec2::new(at.x, at.y)).1
    }

    fn view(&self, world: Vec3) -> Vec3 {
        self.of_camera.view(world)
    }

    fn project(&self, view: Vec3) -> Pos2 {
        let place = self.of_camera.pixel_of_view(view);
        self.rect.min + vec2(place.x, place.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    fn projection() -> Projection {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::new(0.3, 0.1, 0.0), 50.0);
        Projection::new(&camera, Rect::from_min_size(pos2(10.0, 20.0), vec2(640.0, 480.0)))
    }

    #[test]
    fn rays_through_what_is_seen_meet_it() {
        let projection = projection();
        for world in [Vec3::ZERO, Vec3::new(1.0, -0.5, 2.0), Vec3::new(-3.0, 1.0, -4.0)] {
            let seen = projection.point(world).unwrap();
            let direction = projection.direction(seen);
            assert!(direction.distance((world - projection.eye()).normalize()) < 1e-4, "{world}");
            let side = projection.metres_per_point(world).unwrap();
            let beside = projection.point(world + 10.0 * side * Vec3::Y.cross(projection.forward()).normalize());
            assert!((beside.unwrap().distance(seen) - 10.0).abs() < 1e-2);
        }
    }

    #[test]
    fn what_is_behind_the_eye_is_not_seen_and_lines_end_before_it() {
        let projection = projection();
        let behind = projection.eye() - projection.forward();
        assert_eq!((projection.point(behind), projection.metres_per_point(behind)), (None, None));
        let seen = projection.segment(Vec3::ZERO, behind).unwrap();
        assert!(seen.iter().all(|p| p.is_finite()) && Some(seen[0]) == projection.point(Vec3::ZERO));
        assert_eq!(projection.segment(behind, behind - projection.forward()), None);
        assert!(projection.segment(Vec3::ZERO, Vec3::X).is_some(), "negative control");
    }
}
