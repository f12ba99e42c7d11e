//! A camera, its lens, its rays and its projection.

mod lens;

pub use lens::{LEAST_F_NUMBER, Lens, MOST_SHIFT, SENSORS_MM, aperture_sample, disc};

use crate::bounds::is_within_reach;
use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Smallest and largest vertical field of view in radians.
pub const FIELD_OF_VIEW: [f32; 2] = [1e-4, 3.1];

/// The range of [`FIELD_OF_VIEW`], in words.
pub fn field_of_view_range() -> String {
    let [narrowest, widest] = FIELD_OF_VIEW.map(f32::to_degrees);
    format!("{narrowest:.3} to {widest:.1} degrees")
}

/// A camera that looks from `eye` at `target`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Name from the source file.
    #[serde(default)]
    pub name: String,
    /// Position in meters.
    pub eye: Vec3,
    /// A point on the optical axis in meters.
    pub target: Vec3,
    /// Direction that appears upward in the picture; need not be perpendicular to the axis.
    pub up: Vec3,
    /// Vertical field of view in radians.
    pub fov_y: f32,
    /// Its lens.
    #[serde(default, skip_serializing_if = "Lens::is_default")]
    pub lens: Lens,
}

impl Camera {
    /// A camera with +Y upward; `fov_y_degrees` is the vertical field of view.
    pub fn look_at(eye: Vec3, target: Vec3, fov_y_degrees: f32) -> Self {
        Self { name: String::new(), eye, target, up: Vec3::Y, fov_y: fov_y_degrees.to_radians(), lens: Lens::default() }
    }

    /// A three-quarter view that holds a sphere of `radius` around `center` in frame.
    pub fn framing(center: Vec3, radius: f32) -> Self {
        let fov_y: f32 = 40.0;
        let distance = 1.1 * radius.max(1e-6) / (0.5 * fov_y.to_radians()).sin();
        Self::look_at(center + distance * Vec3::new(0.45, 0.35, 0.82).normalize(), center, fov_y)
    }

    /// Whether its points are within reach, its upward direction is finite, its field of view is in [`FIELD_OF_VIEW`], and its lens is
    /// valid.
    pub fn is_valid(&self) -> bool {
        let [narrowest, widest] = FIELD_OF_VIEW;
        let is_open = (narrowest..=widest).contains(&self.fov_y) && self.lens.is_valid();
        is_within_reach(self.eye) && is_within_reach(self.target) && is_within_reach(self.up) && is_open
    }

    /// Columns are the right, up and backward axes of the camera in world space.
    pub fn world_from_view(&self) -> Mat3 {
        let backward = (self.eye - self.target).normalize_or(Vec3::Z);
        let right = self.up.cross(backward).try_normalize();
        let right = right.unwrap_or_else(|| backward.any_orthonormal_vector());
        Mat3::from_cols(right, backward.cross(right), backward)
    }

    /// Half the height of the picture at a depth of 1.
    pub fn tan_half_fov(&self) -> f32 {
        (0.5 * self.fov_y).tan()
    }

    /// Its projection onto a picture of `size` pixels.
    pub fn projection(&self, size: [u32; 2]) -> Projection {
        Projection::new(self, Vec2::new(size[0] as f32, size[1] as f32))
    }

    /// The unit direction through the center of the lens and `pixel` of a picture of `size`, see [`Projection::ray`].
    pub fn direction_through(&self, pixel: Vec2, size: [u32; 2]) -> Vec3 {
        self.projection(size).ray(pixel).1
    }
}

/// A camera with its picture: maps pixels to rays, and points to pixels. Positions in the picture are in pixels from
/// its top left corner; the center of the first pixel is (0.5, 0.5). Twin of `shaders/camera.wgsl`.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Position of the eye in meters.
    pub eye: Vec3,
    /// Columns are the right, up and backward axes of the camera.
    pub world_from_view: Mat3,
    view_from_world: Mat3,
    /// Half the height of the picture at a depth of 1.
    pub tan_half_fov: f32,
    size: Vec2,
    /// Where the optical axis meets the picture, in pixels.
    pub center: Vec2,
    /// Distance of the picture plane from the eye in pixels.
    pub focal: f32,
}

impl Projection {
    /// The projection onto a picture of `size`, in pixels or any other unit.
    pub fn new(camera: &Camera, size: Vec2) -> Self {
        let (world_from_view, tan_half_fov) = (camera.world_from_view(), camera.tan_half_fov());
        let center = 0.5 * size + size.y * camera.lens.shift * Vec2::new(-1.0, 1.0);
        Self {
            eye: camera.eye,
            world_from_view,
            view_from_world: world_from_view.transpose(),
            tan_half_fov,
            size,
            center,
            focal: 0.5 * size.y / tan_half_fov,
        }
    }

    /// Origin and unit direction of the ray through `pixel` of a pinhole, see [`Camera::through`].
    #[inline]
    pub fn ray(&self, pixel: Vec2) -> (Vec3, Vec3) {
        let ndc = (2.0 * pixel - 2.0 * self.center) / self.size.y;
        let tan = self.tan_half_fov;
        (self.eye, (self.world_from_view * Vec3::new(ndc.x * tan, -ndc.y * tan, -1.0)).normalize())
    }

    /// The unit direction of the optical axis.
    pub fn forward(&self) -> Vec3 {
        -self.world_from_view.z_axis
    }

    /// Depth of a point in meters.
    pub fn depth(&self, point: Vec3) -> f32 {
        (point - self.eye).dot(self.forward())
    }

    /// A point in the space of the camera: right, up, backward.
    #[inline]
    pub fn view(&self, point: Vec3) -> Vec3 {
        self.view_from_world * (point - self.eye)
    }

    /// Position in the picture times depth, and depth in meters: homogeneous, so points behind the eye are harmless.
    #[inline]
    pub fn project(&self, point: Vec3) -> Vec3 {
        let p = self.view(point);
        let depth = -p.z;
        Vec3::new(self.center.x * depth + self.focal * p.x, self.center.y * depth - self.focal * p.y, depth)
    }

    /// Position in the picture and depth of a point in front of the eye.
    #[inline]
    pub fn pixel_of(&self, point: Vec3) -> Option<(Vec2, f32)> {
        let projected = self.project(point);
        (projected.z > 0.0).then(|| (projected.truncate() / projected.z, projected.z))
    }

    /// Position in the picture of a point in camera space, in front of the eye.
    pub fn pixel_of_view(&self, view: Vec3) -> Vec2 {
        self.center + self.focal / -view.z * Vec2::new(view.x, -view.y)
    }

    /// Size of a pixel in meters at a depth.
    pub fn pixel_span(&self, depth: f32) -> f32 {
        depth * 2.0 * self.tan_half_fov / self.size.y
    }

    /// Matrix for a rasterizer that samples at pixel centers, to sample at `in_pixel` of each instead. Depth is near /
    /// distance: 1 at the near plane, 0 at infinity.
    pub fn clip_from_world(&self, in_pixel: Vec2, near: f32) -> Mat4 {
        let (size, tan) = (self.size, self.tan_half_fov);
        let beside = 2.0 * (self.center - 0.5 * size);
        let shift = (Vec2::splat(1.0) - 2.0 * in_pixel + beside) / size * Vec2::new(1.0, -1.0);
        let clip_from_view = Mat4::from_cols(
            Vec4::new(size.y / (size.x * tan), 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / tan, 0.0, 0.0),
            Vec4::new(-shift.x, -shift.y, 0.0, -1.0),
            Vec4::new(0.0, 0.0, near, 0.0),
        );
        clip_from_view * Mat4::from_mat3(self.view_from_world) * Mat4::from_translation(-self.eye)
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

    #[test]
    fn projection_inverts_the_rays() {
        let camera = Camera::look_at(Vec3::new(0.3, 1.0, 4.0), Vec3::new(0.0, 0.2, 0.0), 40.0);
        let projection = camera.projection([64, 48]);
        for pixel in [Vec2::new(0.5, 0.5), Vec2::new(40.0, 7.25), Vec2::new(63.5, 47.5)] {
            let (origin, direction) = projection.ray(pixel);
            let (seen, depth) = projection.pixel_of(origin + 3.0 * direction).unwrap();
            assert!((seen - pixel).length() < 1e-3 && depth > 2.0, "{seen}");
            assert_eq!(projection.pixel_of(origin - direction), None);
        }
    }

    #[test]
    fn a_point_seen_through_a_jittered_sample_lands_on_the_centre_of_its_pixel() {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.2, 0.1, -0.5), 50.0);
        let projection = camera.projection([64, 48]);
        for (pixel, offset) in [([3.0, 5.0], [0.1, 0.8]), ([60.0, 40.0], [0.9, 0.2]), ([0.0, 0.0], [0.5, 0.5])] {
            let (pixel, offset) = (Vec2::from(pixel), Vec2::from(offset));
            let (origin, direction) = projection.ray(pixel + offset);
            let clip = projection.clip_from_world(offset, 0.01) * (origin + 7.0 * direction).extend(1.0);
            let ndc = clip / clip.w;
            let position = Vec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * Vec2::new(64.0, 48.0);
            assert!((position - pixel - 0.5).length() < 1e-3, "{position} for {pixel}");
            assert!(ndc.z > 0.0 && ndc.z < 1.0);
        }
    }
}
