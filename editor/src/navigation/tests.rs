use super::*;
use std::f32::consts::{FRAC_PI_2, PI};

const SIZE: [u32; 2] = [800, 600];

fn camera() -> Camera {
    Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::new(0.5, 0.5, 0.0), 40.0)
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-4
}

/// Position of a point in the picture, in pixels.
fn projected(camera: &Camera, point: Vec3) -> Vec2 {
    let view = camera.world_from_view().transpose() * (point - camera.eye);
    let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    let focal = 0.5 * size.y / (0.5 * camera.fov_y).tan();
    0.5 * size + focal * Vec2::new(view.x, -view.y) / -view.z
}

#[test]
fn orbiting_keeps_target_and_distance_and_turns_by_the_angle() {
    let level = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 40.0);
    let quarter = orbit(&level, FRAC_PI_2, 0.0);
    assert!(close(quarter.eye, Vec3::new(3.0, 0.0, 0.0)), "{}", quarter.eye);
    let raised = orbit(&level, 0.0, FRAC_PI_2 / 3.0);
    assert!(close(raised.eye, 3.0 * Vec3::new(0.0, 0.5, 0.75_f32.sqrt())), "{}", raised.eye);
    let there = orbit(&camera(), 0.7, 0.2);
    assert_eq!(there.target, camera().target);
    assert!((distance(&there) - distance(&camera())).abs() < 1e-4);
    assert!(close(orbit(&there, -0.7, -0.2).eye, camera().eye));
    assert!(!close(orbit(&there, 0.7, -0.2).eye, camera().eye), "negative control");
}

#[test]
fn nothing_flips_at_the_poles() {
    for up in [1.0, -1.0] {
        let mut now = camera();
        for _ in 0..200 {
            let next = orbit(&now, 0.0, 0.05 * up);
            let right = |camera: &Camera| camera.world_from_view().x_axis;
            assert!(right(&next).dot(right(&now)) > 0.99);
            now = next;
        }
        assert!((now.eye.y - now.target.y) * up > 0.99 * distance(&now));
    }
    // A camera that looks exactly along the vertical keeps its yaw when turned away from it.
    let down = Camera { up: Vec3::NEG_Z, ..Camera::look_at(Vec3::Y, Vec3::ZERO, 40.0) };
    let tilted = orbit(&down, 0.0, -0.5);
    assert!(close(tilted.world_from_view().x_axis, Vec3::X));
}

#[test]
fn the_point_under_the_pointer_follows_a_pan() {
    let (from, to) = (Vec2::new(200.0, 400.0), Vec2::new(330.0, 120.0));
    let point = point_on_target_plane(&camera(), from, SIZE);
    assert!((projected(&camera(), point) - from).length() < 1e-2);
    let panned = pan(&camera(), to - from, 600.0);
    assert!((projected(&panned, point) - to).length() < 1e-2);
    let wrong = pan(&camera(), from - to, 600.0);
    assert!((projected(&wrong, point) - to).length() > 100.0, "negative control");
}

#[test]
fn a_dolly_keeps_what_is_under_the_pointer_and_stops_before_it() {
    let point = Vec3::new(-0.4, 0.9, 1.0);
    let nearer = dolly(&camera(), 0.5, point, 10.0);
    assert!((projected(&nearer, point) - projected(&camera(), point)).length() < 0.1);
    assert!((nearer.eye.distance(point) - 0.5 * camera().eye.distance(point)).abs() < 1e-4);
    let back = dolly(&nearer, 2.0, point, 10.0);
    assert!(close(back.eye, camera().eye) && close(back.target, camera().target));
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(dolly(&camera(), bad, point, 10.0), camera());
    }
    let mut now = camera();
    for _ in 0..500 {
        now = dolly(&now, 0.8, point, 10.0);
    }
    assert!(now.eye.distance(point) >= 0.9 * REACH[0] * 10.0 && distance(&now) > 0.0);
    for _ in 0..500 {
        now = dolly(&now, 1.25, point, 10.0);
    }
    let apart = now.eye.distance(point);
    assert!(apart <= 1.01 * REACH[1] * 10.0 && apart > 0.9 * REACH[1] * 10.0);
}

#[test]
fn flight_does_not_depend_on_the_frame_rate() {
    let motion = Vec3::new(1.0, 0.0, 1.0);
    let at = |rate: u32| (0..rate).fold(camera(), |now, _| fly(&now, motion, 2.0, 1.0 / rate as f32));
    assert!(close(at(10).eye, at(144).eye));
    assert!((at(60).eye.distance(camera().eye) - 2.0).abs() < 1e-3, "diagonals are not faster");
    let ahead = fly(&camera(), Vec3::Z, 1.0, 0.1);
    assert!((distance(&camera()) - ahead.eye.distance(camera().target) - 0.1).abs() < 1e-5);
    let stalled = fly(&camera(), Vec3::Z, 1.0, 60.0);
    assert!(stalled.eye.distance(camera().eye) < 0.2);
}

#[test]
fn looking_to_the_left_turns_the_view_about_the_eye() {
    let level = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 40.0);
    let left = look(&level, FRAC_PI_2, 0.0);
    assert_eq!(left.eye, level.eye);
    assert!(close(left.target, Vec3::NEG_X), "{}", left.target);
    assert!(look(&level, 0.0, 0.5).target.y < 0.0);
}

#[test]
fn framing_fits_the_sphere_to_the_narrower_axis() {
    let bounds = Bounds { min: Vec3::new(2.0, 0.0, -1.0), max: Vec3::new(4.0, 2.0, 1.0) };
    let radius = 0.5 * bounds.diagonal();
    for aspect in [0.3, 1.0, 2.5] {
        let framed = framed(&camera(), bounds, aspect);
        assert_eq!(framed.target, bounds.center());
        let before = camera().world_from_view().z_axis;
        assert!(close(framed.world_from_view().z_axis, before), "the direction stays");
        let needed = (radius / distance(&framed)).asin();
        let half_y = 0.5 * framed.fov_y;
        let half_x = (half_y.tan() * aspect).atan();
        assert!(needed < half_y.min(half_x) && needed > 0.85 * half_y.min(half_x), "{aspect}");
    }
    let point = Bounds { min: Vec3::ONE, max: Vec3::ONE };
    assert!(distance(&framed(&camera(), point, 1.0)) > 0.0);
    let nothing = Bounds::around([]);
    assert_eq!(framed(&camera(), nothing, 1.0), camera());
}

#[test]
fn a_dolly_zoom_keeps_the_size_at_the_target() {
    let above = camera().target + 0.3 * camera().world_from_view().y_axis;
    let wide = with_field_of_view(&camera(), 80.0_f32.to_radians(), true);
    assert!((projected(&wide, above) - projected(&camera(), above)).length() < 0.1);
    let plain = with_field_of_view(&camera(), 80.0_f32.to_radians(), false);
    assert_eq!(plain.eye, camera().eye);
    assert!((projected(&plain, above) - projected(&camera(), above)).length() > 5.0, "negative control");
    assert!(with_field_of_view(&camera(), 9.0, false).fov_y < PI);
}

#[test]
fn what_is_clicked_comes_to_the_centre_at_its_depth() {
    let point = Vec3::new(-0.4, 0.9, 1.0);
    let centered = centered_on(&camera(), point);
    assert_eq!(centered.target, point);
    assert!((projected(&centered, point) - Vec2::new(400.0, 300.0)).length() < 1e-2);
    let depth = (camera().world_from_view().transpose() * (point - camera().eye)).z;
    assert!((distance(&centered) + depth).abs() < 1e-4);
    assert!(close(centered.world_from_view().z_axis, camera().world_from_view().z_axis));
    let behind = camera().eye + camera().world_from_view().z_axis;
    assert_eq!(centered_on(&camera(), behind), camera());
}

#[test]
fn axis_views_look_along_the_axes_with_the_known_right_hand_side() {
    for (view, from, right) in [
        (AxisView::Front, Vec3::Z, Vec3::X),
        (AxisView::Right, Vec3::X, Vec3::NEG_Z),
        (AxisView::Top, Vec3::Y, Vec3::X),
    ] {
        let frame = axis_view(&camera(), view).world_from_view();
        assert!(frame.z_axis.dot(from) > 0.999_99 && frame.x_axis.dot(right) > 0.999_99, "{view:?}");
    }
}

#[test]
fn no_move_lets_a_number_in_that_is_none() {
    let bounds = Bounds { min: Vec3::NAN, max: Vec3::ONE };
    for bad in [f32::NAN, f32::INFINITY] {
        let moves = [
            orbit(&camera(), bad, bad),
            look(&camera(), bad, 0.0),
            pan(&camera(), Vec2::splat(bad), 600.0),
            pan(&camera(), Vec2::ONE, bad * 0.0),
            dolly(&camera(), 0.5, Vec3::splat(bad), 1.0),
            dolly(&camera(), bad, Vec3::ZERO, bad),
            fly(&camera(), Vec3::ONE, bad, 0.1),
            framed(&camera(), bounds, 1.0),
            framed(&camera(), Bounds { min: Vec3::ZERO, ..bounds }, bad * 0.0),
            centered_on(&camera(), Vec3::splat(bad)),
            with_field_of_view(&camera(), f32::NAN, true),
        ];
        for (index, after) in moves.iter().enumerate() {
            assert!(after.eye.is_finite() && after.target.is_finite() && after.fov_y.is_finite(), "{index}, {bad}");
            assert!(distance(after) > 0.0, "{index}, {bad}");
        }
    }
}
