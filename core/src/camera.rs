//! A pinhole camera and its rays.

use crate::bounds::is_within_reach;
use glam::{Mat3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Smallest and largest vertical field of view in radians.
pub const FIELD_OF_VIEW: [f32; 2] = [1e-4, 3.1];

/// What [`FIELD_OF_VIEW`] allows, in words.
pub fn field_of_view_range() -> String {
    let [narrowest, widest] = FIELD_OF_VIEW.map(f32::to_degrees);
    format!("{narrowest:.3} to {widest:.1} degrees")
}

/// A pinhole camera that looks from `eye` at `target`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Name from the source file.
    #[serde(default)]
    pub name: String,
    /// Position in metres.
    pub eye: Vec3,
    /// A point on the optical axis in metres.
    pub target: Vec3,
    /// Direction that appears upward in the picture; need not be perpendicular to the axis.
    pub up: Vec3,
    /// Vertical field of view in radians.
    pub fov_y: f32,
}

impl Camera {
    /// A camera with +Y upward; `fov_y_degrees` is the vertical field of view.
    pub fn look_at(eye: Vec3, target: Vec3, fov_y_degrees: f32) -> Self {
        Self { name: String::new(), eye, target, up: Vec3::Y, fov_y: fov_y_degrees.to_radians() }
    }

    /// A three-quarter view that holds a sphere of `radius` around `center` in frame.
    pub fn framing(center: Vec3, radius: f32) -> Self {
        let fov_y: f32 = 40.0;
        let distance = 1.1 * radius.max(1e-6) / (0.5 * fov_y.to_radians()).sin();
        Self::look_at(center + distance * Vec3::new(0.45, 0.35, 0.82).normalize(), center, fov_y)
    }

    /// Whether its places are within reach, its upward direction is finite, and its field of view is in [`FIELD_OF_VIEW`].
    pub fn is_valid(&self) -> bool {
        let [narrowest, widest] = FIELD_OF_VIEW;
        let lens = (narrowest..=widest).contains(&self.fov_y);
        is_within_reach(self.eye) && is_within_reach(self.target) && is_within_reach(self.up) && lens
    }

    /// Columns are the right, up and backward axes of the camera in world space.
    pub fn world_from_view(&self) -> Mat3 {
        let backward = (self.eye - self.target).normalize_or(Vec3::Z);
        let right = self.up.cross(backward).try_normalize();
        let right = right.unwrap_or_else(|| backward.any_orthonormal_vector());
        Mat3::from_cols(right, backward.cross(right), backward)
    }

    /// The unit direction through `pixel`, a position in pixels from the top left corner of a picture of
    /// `size`; the centre of the first pixel is (0.5, 0.5).
    pub fn direction_through(&self, pixel: Vec2, size: [u32; 2]) -> Vec3 {
        self.lens(size).direction_through(pixel)
    }

    /// The directions through the pixels of a picture of `size`.
    pub fn lens(&self, size: [u32; 2]) -> Lens {
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        Lens { world_from_view: self.world_from_view(), tan_half_fov: (0.5 * self.fov_y).tan(), size }
    }
}

/// A camera with a picture size, for the directions through many pixels.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    world_from_view: Mat3,
    tan_half_fov: f32,
    size: Vec2,
}

impl Lens {
    /// As [`Camera::direction_through`].
    #[inline]
    pub fn direction_through(&self, pixel: Vec2) -> Vec3 {
        let ndc = (2.0 * pixel - self.size) / self.size.y;
        let tan = self.tan_half_fov;
        (self.world_from_view * Vec3::new(ndc.x * tan, -ndc.y * tan, -1.0)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_looks_along_the_axis_and_corners_open_by_the_field_of_view() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 90.0);
        let centre = camera.direction_through(Vec2::new(50.0, 50.0), [100, 100]);
        assert!((centre - Vec3::NEG_Z).length() < 1e-6);
        let top = camera.direction_through(Vec2::new(50.0, 0.0), [100, 100]);
        assert!((top - Vec3::new(0.0, 1.0, -1.0).normalize()).length() < 1e-6);
        let right = camera.direction_through(Vec2::new(100.0, 50.0), [100, 100]);
        assert!(right.x > 0.7);
    }

    #[test]
    fn looking_straight_down_still_gives_an_orthonormal_frame() {
        let camera = Camera::look_at(Vec3::Y, Vec3::ZERO, 40.0);
        let frame = camera.world_from_view();
        assert!((frame.transpose() * frame - Mat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-6));
    }
}
