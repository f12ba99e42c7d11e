//! Moves of the camera: pure functions from one camera to the next.
//!
//! Turns like a turntable: yaw about +Y and pitch, so that the horizon stays level and nothing flips at the poles. An invalid move
//! (NaN, infinity, the eye on its target) returns the camera unchanged.

use glam::{Vec2, Vec3};
use lapidary_core::{bounds::Bounds, camera::Camera};

/// Turning stops just short of the poles, where +Y no longer defines up.
const MAX_PITCH: f32 = 89.9_f32.to_radians();

/// Limits of the vertical field of view in radians, as on the command line.
const FOV: [f32; 2] = [1.0_f32.to_radians(), 170.0_f32.to_radians()];

/// Nearest and farthest distance of a dolly, in diagonals of the scene. Nearer than this, neighboring eye positions are no longer
/// distinct in `f32` for a scene that lies some diagonals off the origin.
const REACH: [f32; 2] = [1e-4, 1e3];

/// Margin factor around a framed subject.
const FRAMING_MARGIN: f32 = 1.1;

/// Longest step of a flight in seconds, so that a stalled frame does not throw the camera out of the scene.
const MAX_STEP_SECS: f32 = 0.1;

/// A view along an axis, with +Y upward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisView {
    /// From +Z.
    Front,
    /// From +X.
    Right,
    /// From +Y, with -Z upward in the picture.
    Top,
}

/// Turns the eye about the target by angles in radians: counter-clockwise seen from above, and upward.
pub fn orbit(camera: &Camera, yaw: f32, pitch: f32) -> Camera {
    let eye = camera.target + distance(camera) * turned_backward(camera, yaw, pitch);
    sound(Camera { eye, up: Vec3::Y, ..camera.clone() }, camera)
}

/// Turns the view about the eye: by `yaw` radians to the left, and by `pitch` downward.
pub fn look(camera: &Camera, yaw: f32, pitch: f32) -> Camera {
    let target = camera.eye - distance(camera) * turned_backward(camera, yaw, pitch);
    sound(Camera { target, up: Vec3::Y, ..camera.clone() }, camera)
}

/// Slides eye and target so that the point under the pointer, at the target's distance, follows it by `delta`, in the
/// units of a picture that is `height` high (y downward).
pub fn pan(camera: &Camera, delta: Vec2, height: f32) -> Camera {
    let frame = camera.world_from_view();
    let unit = 2.0 * distance(camera) * camera.tan_half_fov() / height;
    moved(camera, unit * (delta.y * frame.y_axis - delta.x * frame.x_axis))
}

/// Scales the distance to the point `toward` by `factor` and keeps the direction of view, so that the point stays in place in the
/// picture. Stops at distances that suit a scene with a diagonal of `scene_size` meters.
pub fn dolly(camera: &Camera, factor: f32, toward: Vec3, scene_size: f32) -> Camera {
    if !(factor > 0.0 && factor.is_finite()) {
        return camera.clone();
    }
    let [nearest, farthest] = REACH.map(|reach| reach * scene_size);
    let apart = camera.eye.distance(toward);
    let factor =
        if factor < 1.0 { factor.max((nearest / apart).min(1.0)) } else { factor.min((farthest / apart).max(1.0)) };
    let eye = toward + factor * (camera.eye - toward);
    let backward = camera.world_from_view().z_axis;
    let target = eye - backward * (factor * distance(camera)).max(nearest);
    sound(Camera { eye, target, ..camera.clone() }, camera)
}

/// Flies for `secs` seconds at `speed` meters a second along `motion`: to the right, up the vertical, and ahead, each
/// -1 to 1.
pub fn fly(camera: &Camera, motion: Vec3, speed: f32, secs: f32) -> Camera {
    let frame = camera.world_from_view();
    let direction = motion.x * frame.x_axis + motion.y * Vec3::Y - motion.z * frame.z_axis;
    moved(camera, direction.clamp_length_max(1.0) * speed * secs.clamp(0.0, MAX_STEP_SECS))
}

/// Keeps the direction and moves so that the sphere around `bounds` fits a picture of `aspect` (width by height).
pub fn framed(camera: &Camera, bounds: Bounds, aspect: f32) -> Camera {
    let radius = (0.5 * bounds.diagonal()).max(1e-6);
    let tan = camera.tan_half_fov();
    let half_angle = tan.min(tan * aspect).atan();
    let target = bounds.center();
    let apart = FRAMING_MARGIN * radius / half_angle.sin();
    let eye = target + apart * camera.world_from_view().z_axis;
    sound(Camera { eye, target, ..camera.clone() }.in_the_middle(), camera)
}

/// Slides the eye across the view so that `point` comes to the center and becomes the target.
pub fn centered_on(camera: &Camera, point: Vec3) -> Camera {
    let backward = camera.world_from_view().z_axis;
    let depth = (camera.eye - point).dot(backward);
    if !(depth > 0.0) {
        return camera.clone();
    }
    sound(Camera { eye: point + depth * backward, target: point, ..camera.clone() }.in_the_middle(), camera)
}

/// Another vertical field of view in radians. With `keep_size` the eye moves so that the target keeps its size in the picture (a
/// dolly zoom).
pub fn with_field_of_view(camera: &Camera, fov_y: f32, keep_size: bool) -> Camera {
    let fov_y = fov_y.clamp(FOV[0], FOV[1]);
    let next = Camera { fov_y, ..camera.clone() };
    let scale = if keep_size { camera.tan_half_fov() / next.tan_half_fov() } else { 1.0 };
    sound(Camera { eye: camera.target + scale * (camera.eye - camera.target), ..next }, camera)
}

/// The target seen along an axis from the same distance.
pub fn axis_view(camera: &Camera, view: AxisView) -> Camera {
    let (yaw, pitch) = match view {
        AxisView::Front => (0.0_f32, 0.0),
        AxisView::Right => (90.0_f32.to_radians(), 0.0),
        AxisView::Top => (0.0, MAX_PITCH),
    };
    let eye = camera.target + distance(camera) * backward_of(yaw, pitch);
    sound(Camera { eye, up: Vec3::Y, ..camera.clone() }, camera)
}

/// The point under `pixel` of a picture of `size`, on the plane through the target that faces the camera.
pub fn point_on_target_plane(camera: &Camera, pixel: Vec2, size: [u32; 2]) -> Vec3 {
    let projection = camera.projection(size);
    let (origin, direction) = projection.ray(pixel);
    origin + direction * (distance(camera) / direction.dot(projection.forward()))
}

fn distance(camera: &Camera) -> f32 {
    camera.eye.distance(camera.target)
}

fn moved(camera: &Camera, by: Vec3) -> Camera {
    sound(Camera { eye: camera.eye + by, target: camera.target + by, ..camera.clone() }, camera)
}

fn turned_backward(camera: &Camera, yaw: f32, pitch: f32) -> Vec3 {
    let frame = camera.world_from_view();
    let backward = frame.z_axis;
    // A vertical view has no yaw; the right vector defines it then.
    let level = backward.x.hypot(backward.z) > 1e-4;
    let yaw_now = if level { backward.x.atan2(backward.z) } else { (-frame.x_axis.z).atan2(frame.x_axis.x) };
    let pitch_now = backward.y.clamp(-1.0, 1.0).asin();
    backward_of(yaw_now + yaw, (pitch_now + pitch).clamp(-MAX_PITCH, MAX_PITCH))
}

fn backward_of(yaw: f32, pitch: f32) -> Vec3 {
    Vec3::new(yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos())
}

/// `next` if it is a valid camera, otherwise `last`.
fn sound(next: Camera, last: &Camera) -> Camera {
    let finite = next.eye.is_finite() && next.target.is_finite() && next.up.is_finite();
    let apart = distance(&next);
    let in_range = (FOV[0]..=FOV[1]).contains(&next.fov_y) || next.fov_y == last.fov_y;
    if finite && in_range && apart > 0.0 && apart.is_finite() { next } else { last.clone() }
}

#[cfg(test)]
mod tests;
