//! Input that moves the camera.

use super::*;
use crate::actions::CameraAction;

#[test]
fn a_left_drag_orbits_so_that_the_scene_follows_the_pointer() {
    let mut harness = harness();
    drag(&mut harness, PointerButton::Primary, Modifiers::NONE, vec2(100.0, 0.0));
    let after = camera(&harness);
    assert_eq!(after.target, Vec3::ZERO);
    assert!(after.eye.x < -1.0 && after.eye.y.abs() < 1e-4, "{}", after.eye);
    drag(&mut harness, PointerButton::Primary, Modifiers::ALT, vec2(0.0, 60.0));
    assert!(camera(&harness).eye.y > 0.5);
    assert_eq!(harness.state().selected, None);
    let all_cameras = harness.state().log.iter().all(|action| matches!(action, Action::Camera(CameraAction::To(_))));
    assert!(all_cameras && !harness.state().last.unwrap().moving);
}

#[test]
fn middle_drags_orbit_and_with_shift_pan() {
    let mut orbited = harness();
    drag(&mut orbited, PointerButton::Middle, Modifiers::NONE, vec2(100.0, 0.0));
    assert!(camera(&orbited).eye.x < -1.0 && camera(&orbited).target == Vec3::ZERO);
    let mut panned = harness();
    drag(&mut panned, PointerButton::Middle, Modifiers::SHIFT, vec2(100.0, 0.0));
    let after = camera(&panned);
    assert!(after.target.x < -0.1 && (after.eye.x - after.target.x).abs() < 1e-5, "{}", after.target);
}

#[test]
fn a_double_click_orbits_about_what_is_clicked() {
    let mut harness = harness();
    let right = seen_at(&harness, 1.0, 0.2);
    click(&mut harness, right);
    click(&mut harness, right);
    let after = camera(&harness);
    assert!((after.target - Vec3::new(1.0, 0.2, 0.0)).length() < 1e-2, "{}", after.target);
    assert!((after.eye - Vec3::new(1.0, 0.2, 5.0)).length() < 1e-2);
}

#[test]
fn without_shift_a_right_drag_looks_and_leaves_the_environment() {
    let mut harness = harness();
    drag(&mut harness, PointerButton::Secondary, Modifiers::NONE, vec2(120.0, 0.0));
    let after = camera(&harness);
    assert_eq!(after.eye, start().eye);
    assert!(after.target.x > 0.5, "{}", after.target);
    assert_eq!(harness.state().document.environment.rotation_degrees, 0.0);
}

#[test]
fn keys_fly_only_while_the_right_button_is_held() {
    let mut harness = harness();
    harness.key_down(Key::W);
    harness.step();
    assert_eq!(camera(&harness), start());
    let center = viewport_center(&harness);
    harness.hover_at(center);
    button(&harness, center, PointerButton::Secondary, true, Modifiers::NONE);
    harness.step();
    harness.run_steps(10);
    assert!(harness.state().state.is_flying() && harness.state().last.unwrap().moving);
    let after = camera(&harness);
    assert!(after.eye.z < 4.95 && after.eye.x.abs() < 1e-5, "{}", after.eye);
    harness.key_up(Key::W);
    harness.step();
    let resting = camera(&harness);
    harness.run();
    assert_eq!(camera(&harness), resting, "nothing moves or repaints when no key is held");
    button(&harness, center, PointerButton::Secondary, false, Modifiers::NONE);
    harness.step();
    assert!(!harness.state().state.is_flying());
}

#[test]
fn the_wheel_dollies_toward_what_is_under_the_pointer() {
    let mut harness = harness();
    let corner = seen_at(&harness, 1.2, 0.3);
    harness.hover_at(corner);
    scroll(&mut harness, MouseWheelUnit::Line, vec2(0.0, 2.0), Modifiers::NONE);
    assert!(harness.state().last.unwrap().moving);
    wait(&mut harness);
    assert!(!harness.state().last.unwrap().moving);
    let after = camera(&harness);
    let point = Vec3::new(1.2, 0.3, 0.0);
    assert!(after.eye.distance(point) < 0.8 * start().eye.distance(point));
    let direction = |camera: &Camera| (point - camera.eye).normalize();
    assert!(direction(&after).dot(direction(&start())) > 0.999_99, "the point stays under the pointer");
}

#[test]
fn two_fingers_orbit_with_alt_and_pinching_dollies() {
    let mut harness = harness();
    let center = viewport_center(&harness);
    harness.hover_at(center);
    scroll(&mut harness, MouseWheelUnit::Point, vec2(6.0, 3.0), Modifiers::ALT);
    let orbited = camera(&harness);
    assert!(orbited.eye.x < 0.0 && orbited.eye.y > 0.0, "{}", orbited.eye);
    assert!((orbited.eye.length() - 5.0).abs() < 1e-4, "no dolly");
    wait(&mut harness);
    assert_eq!(camera(&harness), orbited);
    harness.event(Event::Zoom(1.25));
    harness.step();
    assert!((camera(&harness).eye.length() - 4.0).abs() < 1e-3);
    harness.remove_cursor();
    harness.event(Event::Zoom(1.25));
    harness.step();
    assert!((camera(&harness).eye.length() - 4.0).abs() < 1e-3, "not while the pointer is elsewhere");
}
