//! The pictures that a bake is for: vertices matter most where their cameras look.

use crate::camera::Camera;
use glam::{Mat3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Surfaces at more grazing angles count with this cosine, so that they are never left without vertices.
const LEAST_COSINE: f32 = 0.05;
/// The picture is enlarged by this factor, so that a camera may move a little.
const MARGIN: f32 = 1.1;

/// Largest width over height of a picture, and height over width.
pub const WIDEST: f32 = 32_768.0;

/// Width over height of a picture whose aspect is unknown.
pub const DEFAULT_ASPECT: f32 = 16.0 / 9.0;

/// A picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shot {
    /// Its camera.
    pub camera: Camera,
    /// Width over height.
    pub aspect: f32,
}

impl Shot {
    /// Whether the camera is usable: valid, with eye and target apart, and a frame at most [`WIDEST`] times as wide as
    /// high or as high as wide.
    pub fn is_valid(&self) -> bool {
        let Camera { eye, target, up, .. } = &self.camera;
        let has_frame = (1.0 / WIDEST..=WIDEST).contains(&self.aspect);
        self.camera.is_valid() && eye != target && *up != Vec3::ZERO && has_frame
    }

    /// The visible part of space.
    pub fn frustum(&self) -> Frustum {
        Frustum {
            eye: self.camera.eye,
            view_from_world: self.camera.world_from_view().transpose(),
            half_height: self.camera.tan_half_fov(),
            shift: 2.0 * self.camera.lens.shift * self.camera.tan_half_fov(),
            aspect: self.aspect,
        }
    }
}

/// The view frustum of a shot, which measures the size of surfaces in its picture.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// Position of the eye, in meters.
    pub eye: Vec3,
    view_from_world: Mat3,
    /// Half the height of the picture at a depth of 1.
    half_height: f32,
    /// The middle of the picture at a depth of 1, beside the optical axis.
    shift: Vec2,
    aspect: f32,
}

impl Frustum {
    /// Area in the picture of an unoccluded surface at `position`, in squares of the picture's height per m². 0 outside
    /// the picture. Both sides of the surface count.
    pub fn magnification(&self, position: Vec3, normal: Vec3) -> f32 {
        let Self { half_height, .. } = *self;
        let view = self.view_from_world * (position - self.eye);
        let depth = -view.z;
        let beside = (view.truncate() - self.shift * depth).abs();
        let inside = beside.y <= MARGIN * half_height * depth && beside.x <= MARGIN * self.aspect * half_height * depth;
        if !(depth > 0.0 && inside) {
            return 0.0;
        }
        let to_eye = self.eye - position;
        let cosine = (to_eye.dot(normal) / to_eye.length()).abs().max(LEAST_COSINE);
        // The picture plane at distance 1 is 2 tan(fov / 2) high; dA' = dA cos distance / depth³.
        cosine * to_eye.length() / (depth.powi(3) * (2.0 * half_height).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shot() -> Shot {
        Shot { camera: Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 90.0), aspect: 2.0 }
    }

    /// Area of a small square's picture by its corners.
    fn by_projection(shot: &Shot, position: Vec3, normal: Vec3) -> f32 {
        let side = normal.any_orthonormal_vector();
        let view_from_world = shot.camera.world_from_view().transpose();
        let project = |p: Vec3| {
            let view = view_from_world * (p - shot.camera.eye);
            view.truncate() / (-view.z * 2.0 * (0.5 * shot.camera.fov_y).tan())
        };
        let step = 1e-2;
        let [o, a, b] = [Vec3::ZERO, side, normal.cross(side)].map(|offset| project(position + offset * step));
        (a - o).perp_dot(b - o).abs() / (step * step)
    }

    #[test]
    fn magnification_is_that_of_a_projected_square() {
        let shot = shot();
        let tilted = Vec3::new(0.3, 0.5, 0.8).normalize();
        for (position, normal) in
            [(Vec3::ZERO, Vec3::Z), (Vec3::new(6.0, 2.0, 1.0), tilted), (Vec3::new(-3.0, -4.0, -2.0), -tilted)]
        {
            let (found, known) =
                (shot.frustum().magnification(position, normal), by_projection(&shot, position, normal));
            assert!((found / known - 1.0).abs() < 0.02, "{found} for {known}");
        }
        let (near, far) =
            (shot.frustum().magnification(Vec3::Z, Vec3::Z), shot.frustum().magnification(-5.0 * Vec3::Z, Vec3::Z));
        assert!(near > 5.0 * far, "negative control");
    }

    #[test]
    fn nothing_is_seen_out_of_the_frame_or_behind() {
        let seen = |x: f32, y: f32, z: f32| shot().frustum().magnification(Vec3::new(x, y, z), Vec3::Z) > 0.0;
        assert!(seen(9.0, 4.0, 0.0) && seen(10.5, 0.0, 0.0));
        assert!(!seen(12.0, 0.0, 0.0) && !seen(0.0, 6.0, 0.0) && !seen(0.0, 0.0, 6.0) && !seen(0.0, 0.0, 5.0));
    }

    #[test]
    fn cameras_that_look_nowhere_are_not_valid() {
        assert!(shot().is_valid());
        let with = |change: fn(&mut Shot)| {
            let mut shot = shot();
            change(&mut shot);
            shot.is_valid()
        };
        assert!(!with(|s| s.camera.target = s.camera.eye));
        assert!(!with(|s| s.camera.eye.x = f32::NAN));
        assert!(!with(|s| s.camera.fov_y = 0.0));
        assert!(!with(|s| s.aspect = f32::INFINITY));
    }
}
