//! The lens of a camera: its aperture, focus and shift.
//!
//! A thin lens images the plane of focus sharply. A picture through it is the mean of pictures through the points of its aperture
//! (Potmesil and Chakravarty 1981, accumulated as by Haeberli and Akeley 1990): each is that of a pinhole with a shifted picture plane.

use super::Camera;
use glam::{DVec2, Vec2};
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;

/// Height of a sensor of 36 x 24 mm, in millimeters.
pub const FULL_FRAME_MM: f32 = 24.0;
/// Smallest and largest height of a sensor, in millimeters.
pub const SENSORS_MM: [f32; 2] = [1.0, 1000.0];
/// Smallest f-number.
pub const LEAST_F_NUMBER: f32 = 1e-6;
/// Largest shift in either direction.
pub const MOST_SHIFT: f32 = 2.0;

/// A thin lens. The default is a pinhole, through which everything is sharp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Lens {
    /// Focal length over diameter of the aperture, at least [`LEAST_F_NUMBER`]; `None` for a pinhole.
    pub f_number: Option<f32>,
    /// Distance from the eye to the plane of focus along the optical axis, in meters; `None` focuses the target.
    pub focus: Option<f32>,
    /// Height of the sensor in millimeters, to which focal lengths and f-numbers belong.
    pub sensor_mm: f32,
    /// How far the picture moves to the right and up beside the optical axis, as shares of its height, without turning the camera:
    /// vertical lines stay parallel. At most [`MOST_SHIFT`].
    pub shift: Vec2,
}

impl Default for Lens {
    fn default() -> Self {
        Self { f_number: None, focus: None, sensor_mm: FULL_FRAME_MM, shift: Vec2::ZERO }
    }
}

impl Lens {
    /// Whether all that it sees is sharp, and its axis is at the center of the picture.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Fewest samples of a pixel with which its blur is smooth: 64 through an aperture.
    pub fn least_samples(&self) -> u32 {
        if self.f_number.is_some() { 64 } else { 1 }
    }

    /// Whether its numbers are in their ranges.
    pub fn is_valid(&self) -> bool {
        let is_open = |f_number: f32| f_number.is_finite() && f_number >= LEAST_F_NUMBER;
        let is_ahead = |focus: f32| focus.is_finite() && focus > 0.0;
        let [least, most] = SENSORS_MM;
        self.f_number.is_none_or(is_open)
            && (least..=most).contains(&self.sensor_mm)
            && self.focus.is_none_or(is_ahead)
            && self.shift.abs().cmple(Vec2::splat(MOST_SHIFT)).all()
    }
}

impl Camera {
    /// Focal length in meters.
    pub fn focal_length(&self) -> f32 {
        0.5e-3 * self.lens.sensor_mm / self.tan_half_fov()
    }

    /// Distance from the eye to the plane of focus along the optical axis, in meters.
    pub fn focus_distance(&self) -> f32 {
        self.lens.focus.unwrap_or_else(|| self.eye.distance(self.target))
    }

    /// Radius of the aperture in meters; 0 for a pinhole.
    pub fn aperture_radius(&self) -> f32 {
        self.lens.f_number.map_or(0.0, |f_number| 0.5 * self.focal_length() / f_number)
    }

    /// The camera moved across the view, so that its target is in the middle of a shifted picture.
    pub fn in_the_middle(self) -> Self {
        let height = 2.0 * self.eye.distance(self.target) * self.tan_half_fov();
        let axes = self.world_from_view();
        let off = height * (self.lens.shift.x * axes.x_axis + self.lens.shift.y * axes.y_axis);
        Self { eye: self.eye - off, target: self.target - off, ..self }
    }

    /// The pinhole camera at a point of the aperture, in its unit disc, that images the plane of focus alike. All renderers see
    /// through pinholes.
    pub fn through(&self, point: Vec2) -> Self {
        let offset = self.aperture_radius() * point;
        let lens = Lens { f_number: None, ..self.lens };
        if offset == Vec2::ZERO {
            return Self { lens, ..self.clone() };
        }
        let axes = self.world_from_view();
        let moved = offset.x * axes.x_axis + offset.y * axes.y_axis;
        // The picture moves back over the plane of focus, whose picture is this high.
        let height = 2.0 * self.focus_distance() * self.tan_half_fov();
        let shift = self.lens.shift - offset / height;
        Self { eye: self.eye + moved, target: self.target + moved, lens: Lens { shift, ..lens }, ..self.clone() }
    }
}

/// Point `i` of a sequence that fills the unit disc evenly for any number, in polar coordinates: a Kronecker sequence by the golden
/// ratio and the square root of 2. Point 0 is the center. It has no common period with the R2 sequence of positions in pixels.
pub fn aperture_sample(i: u32) -> Vec2 {
    const STEP: DVec2 = DVec2::new(0.618_033_988_749_895, std::f64::consts::SQRT_2 - 1.0);
    disc((STEP * f64::from(i)).fract().as_vec2())
}

/// Maps the unit square to the unit disc, with equal areas: the first number is the area within the radius.
pub fn disc(square: Vec2) -> Vec2 {
    let radius = square.x.sqrt();
    radius * Vec2::from_angle(TAU * square.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn camera() -> Camera {
        let camera = Camera::look_at(Vec3::new(0.3, 1.0, 4.0), Vec3::new(0.0, 0.2, 0.0), 40.0);
        Camera {
            lens: Lens { f_number: Some(0.02), focus: Some(3.0), shift: Vec2::new(0.2, -0.1), ..Lens::default() },
            ..camera
        }
    }

    #[test]
    fn the_plane_of_focus_is_seen_alike_through_all_of_the_aperture_and_other_planes_are_not() {
        let (camera, size) = (camera(), [64, 48]);
        let [middle, aside] = [Vec2::ZERO, Vec2::new(-0.6, 0.7)].map(|point| camera.through(point).projection(size));
        for pixel in [Vec2::new(1.0, 2.0), Vec2::new(50.0, 40.5)] {
            let (origin, direction) = middle.ray(pixel);
            let at = |depth: f32| origin + direction * (depth / direction.dot(middle.forward()));
            let off = |depth: f32| aside.pixel_of(at(depth)).unwrap().0.distance(pixel);
            assert!(off(3.0) < 1e-3, "{}", off(3.0));
            assert!(off(2.0) > 1.0 && off(6.0) > 1.0, "negative control: {} {}", off(2.0), off(6.0));
        }
    }

    #[test]
    fn the_circle_of_confusion_has_the_size_of_the_thin_lens() {
        // c = A f (D - s) / (D (s - f)) on the sensor, for an aperture A and a distance s in focus; this camera's picture plane is at
        // the focal length, not behind it, so that its field of view stays: s - f becomes s.
        let camera = Camera { lens: Lens { shift: Vec2::ZERO, ..camera().lens }, ..camera() };
        let (focal, aperture) = (camera.focal_length(), 2.0 * camera.aperture_radius());
        let size = [480, 480];
        for depth in [1.5_f32, 5.0, 40.0] {
            let point = camera.eye + (camera.target - camera.eye).normalize() * depth;
            let seen = |x: f32| camera.through(Vec2::new(x, 0.0)).projection(size).pixel_of(point).unwrap().0.x;
            let on_sensor = aperture * focal * (depth - 3.0).abs() / (depth * 3.0);
            let pixels = on_sensor / 0.024 * 480.0;
            assert!(((seen(1.0) - seen(-1.0)).abs() / pixels - 1.0).abs() < 1e-3, "{depth}");
        }
    }

    #[test]
    fn a_shift_moves_the_picture_by_shares_of_its_height() {
        let shifted = Camera { lens: Lens { shift: Vec2::new(0.25, 0.5), ..Lens::default() }, ..camera() };
        let straight = Camera { lens: Lens::default(), ..camera() };
        let pixel = |camera: &Camera| camera.projection([64, 40]).pixel_of(Vec3::new(0.1, 0.4, 0.3)).unwrap().0;
        let moved = pixel(&shifted) - pixel(&straight);
        assert!((moved - Vec2::new(-10.0, 20.0)).length() < 1e-3, "{moved}: the view goes right and up");
    }

    #[test]
    fn a_target_comes_to_the_middle_of_a_shifted_picture() {
        let target = camera().target;
        let seen = |camera: &Camera| camera.projection([64, 40]).pixel_of(target).unwrap().0;
        assert!(seen(&camera()).distance(Vec2::new(32.0, 20.0)) > 3.0, "negative control");
        assert!(seen(&camera().in_the_middle()).distance(Vec2::new(32.0, 20.0)) < 1e-3);
    }

    #[test]
    fn points_of_the_aperture_fill_the_disc_from_its_center() {
        assert_eq!(aperture_sample(0), Vec2::ZERO);
        for count in [16, 64, 256] {
            let points: Vec<Vec2> = (0..count).map(aperture_sample).collect();
            let share =
                |is_in: &dyn Fn(&Vec2) -> bool| points.iter().filter(|p| is_in(p)).count() as f32 / count as f32;
            for (half, expected) in [
                (share(&|p| p.x > 0.0), 0.5),
                (share(&|p| p.y > 0.0), 0.5),
                (share(&|p| p.length_squared() < 0.5), 0.5),
                (share(&|p| p.x > 0.0 && p.y > 0.0), 0.25),
            ] {
                assert!((half - expected).abs() < 0.13, "{count}: {half} for {expected}");
            }
            assert!(points.iter().all(|p| p.length() <= 1.0));
        }
    }

    #[test]
    fn a_pinhole_stays_as_it_is_and_bad_numbers_are_not_valid() {
        let pinhole = Camera { lens: Lens::default(), ..camera() };
        assert_eq!(pinhole.through(Vec2::new(0.3, 0.3)), pinhole);
        assert!(camera().is_valid() && pinhole.is_valid());
        for bad in [
            Lens { f_number: Some(0.0), ..Lens::default() },
            Lens { f_number: Some(f32::INFINITY), ..Lens::default() },
            Lens { focus: Some(-1.0), ..Lens::default() },
            Lens { shift: Vec2::new(f32::NAN, 0.0), ..Lens::default() },
            Lens { shift: Vec2::new(0.0, 3.0), ..Lens::default() },
        ] {
            assert!(!Camera { lens: bad, ..camera() }.is_valid(), "{bad:?}");
        }
    }
}
