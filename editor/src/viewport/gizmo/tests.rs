//! Handles in a viewport without a window. This file tests handles of lights: selection, and results of drags.

mod objects;

use super::projection::Projection;
use crate::{
    actions::{Action, CameraAction, LightAction, SelectAction},
    document::Edit,
    viewport::{
        ClickFor,
        test_window::{App, button, click, harness, seen_at},
    },
};
use egui::{Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;
use lapidary_core::{camera::Camera, lights::Light, test_scenes};

/// Aimed at the left square.
fn spot() -> Light {
    Light { position: Vec3::new(0.2, 0.6, 0.5), target: Vec3::new(-1.0, 0.0, 0.0), ..test_scenes::light() }
}

/// Two lights, and the camera at an angle, so that all axes are seen.
fn lit() -> Harness<'static, App> {
    let mut harness = harness();
    let app = harness.state_mut();
    app.document.lights = vec![spot(), Light { position: Vec3::new(-0.6, -0.8, 0.0), ..spot() }];
    app.document.camera.eye = Vec3::new(2.0, 1.5, 4.0);
    harness.run();
    harness
}

fn at(harness: &Harness<App>, world: Vec3) -> Pos2 {
    let rect = harness.get_by_label("Viewport").rect();
    Projection::new(&harness.state().document.camera, rect).point(world).unwrap()
}

/// Position of the pointer on an axis of the selected light.
fn on_axis(harness: &Harness<App>, axis: Vec3) -> Pos2 {
    let rect = harness.get_by_label("Viewport").rect();
    let projection = Projection::new(&harness.state().document.camera, rect);
    let light = &harness.state().document.lights[0];
    at(harness, light.position + 60.0 * projection.metres_per_point(light.position).unwrap() * axis)
}

fn press(harness: &mut Harness<App>, pos: Pos2) {
    harness.hover_at(pos);
    button(harness, pos, PointerButton::Primary, true, Modifiers::NONE);
    harness.step();
}

fn release(harness: &mut Harness<App>, pos: Pos2) {
    button(harness, pos, PointerButton::Primary, false, Modifiers::NONE);
    harness.step();
    harness.run();
}

fn drag(harness: &mut Harness<App>, from: Pos2, by: Vec2) {
    press(harness, from);
    for share in [0.3, 0.7, 1.0] {
        harness.hover_at(from + share * by);
        harness.step();
    }
    release(harness, from + by);
}

fn select(harness: &mut Harness<App>) {
    let lamp = at(harness, spot().position);
    click(harness, lamp);
    assert_eq!(harness.state().selected_light, Some(0));
    harness.state_mut().log.clear();
    harness.run();
}

/// A light during a drag, with the button down; the lamp's position and the camera before.
fn half_dragged() -> (Harness<'static, App>, Pos2, Camera) {
    let mut harness = lit();
    select(&mut harness);
    let camera = harness.state().document.camera.clone();
    let lamp = at(&harness, spot().position);
    press(&mut harness, lamp);
    harness.hover_at(lamp + vec2(40.0, 0.0));
    harness.step();
    (harness, lamp, camera)
}

fn light<'a>(harness: &'a Harness<App>) -> &'a Light {
    &harness.state().document.lights[0]
}

fn gestures(harness: &Harness<App>) -> usize {
    harness.state().log.iter().filter(|action| matches!(action, Action::EndGesture)).count()
}

#[test]
fn a_click_on_a_lamp_selects_it_before_the_objects_behind() {
    let mut harness = lit();
    select(&mut harness);
    let other = at(&harness, Vec3::new(-0.6, -0.8, 0.0));
    click(&mut harness, other);
    assert_eq!(harness.state().selected_light, Some(1));
    assert!(!harness.state().log.iter().any(|a| matches!(a, Action::Select(SelectAction::Object(_)))));
    let object = at(&harness, Vec3::new(1.3, 0.0, 0.0));
    click(&mut harness, object);
    assert!(matches!(
        harness.state().log[..],
        [
            ..,
            Action::Select(SelectAction::Object(Some(1))),
            Action::Select(SelectAction::Material(_)),
            Action::Select(SelectAction::Part(_))
        ]
    ));
}

#[test]
fn a_drag_of_an_axis_moves_the_light_along_it_by_as_much_as_the_pointer() {
    for (index, axis) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
        let mut harness = lit();
        select(&mut harness);
        let from = on_axis(&harness, axis);
        let to = on_axis(&harness, 1.8 * axis);
        drag(&mut harness, from, to - from);
        let moved = light(&harness).position - spot().position;
        assert!(moved[index] > 0.1 && (moved - moved[index] * axis).length() < 1e-5, "{axis}: {moved}");
        let grabbed = spot().position;
        let expected = at(&harness, grabbed + moved).distance(at(&harness, grabbed));
        assert!((expected / (to - from).length() - 1.0).abs() < 0.2, "{axis}: {expected} of {}", (to - from).length());
        assert_eq!((light(&harness).target, gestures(&harness)), (spot().target, 1));
        assert!(
            !harness
                .state()
                .log
                .iter()
                .any(|a| matches!(a, Action::Camera(CameraAction::To(_)) | Action::Light(LightAction::Select(_))))
        );
    }
}

#[test]
fn the_disc_moves_in_the_plane_of_the_view_and_the_picture_is_coarse_meanwhile() {
    let mut harness = lit();
    select(&mut harness);
    let lamp = at(&harness, spot().position);
    press(&mut harness, lamp);
    harness.hover_at(lamp + vec2(40.0, -25.0));
    harness.step();
    assert!(harness.state().last.unwrap().moving);
    release(&mut harness, lamp + vec2(40.0, -25.0));
    assert!(!harness.state().last.unwrap().moving);
    let moved = light(&harness).position - spot().position;
    let camera = &harness.state().document.camera;
    assert!(moved.length() > 0.1 && moved.dot(camera.target - camera.eye).abs() < 1e-4, "{moved}");
    assert!(at(&harness, light(&harness).position).distance(lamp + vec2(40.0, -25.0)) < 0.5);
}

#[test]
fn escape_puts_the_light_back_and_the_rest_of_the_drag_does_nothing() {
    let (mut harness, lamp, camera) = half_dragged();
    assert_ne!(light(&harness), &spot(), "negative control");
    harness.key_press(Key::Escape);
    harness.step();
    assert_eq!(light(&harness), &spot());
    harness.hover_at(lamp + vec2(90.0, 30.0));
    harness.step();
    release(&mut harness, lamp + vec2(90.0, 30.0));
    assert_eq!((light(&harness), &harness.state().document.camera), (&spot(), &camera));
    assert_eq!(gestures(&harness), 1);
}

#[test]
fn a_drag_whose_light_vanishes_ends_and_the_rest_of_it_does_nothing() {
    let (mut harness, lamp, camera) = half_dragged();
    assert_eq!(gestures(&harness), 0, "negative control");
    harness.state_mut().document.lights.clear();
    harness.step();
    assert_eq!(gestures(&harness), 1);
    harness.hover_at(lamp + vec2(90.0, 30.0));
    harness.step();
    release(&mut harness, lamp + vec2(90.0, 30.0));
    assert_eq!((gestures(&harness), &harness.state().document.camera), (1, &camera));
}

#[test]
fn the_target_follows_the_surface_under_the_pointer() {
    let mut harness = lit();
    select(&mut harness);
    let from = at(&harness, spot().target);
    let onto = Vec3::new(1.2, 0.2, 0.0);
    let to = at(&harness, onto);
    drag(&mut harness, from, to - from);
    assert!(light(&harness).target.distance(onto) < 0.02, "{}", light(&harness).target);
    assert_eq!(light(&harness).position, spot().position);
}

#[test]
fn a_drag_beside_the_handles_orbits_and_without_a_selection_there_are_none() {
    let mut harness = lit();
    let lamp = at(&harness, spot().position);
    drag(&mut harness, lamp, vec2(40.0, 0.0));
    assert_eq!(light(&harness), &spot());
    assert!(harness.state().log.iter().any(|action| matches!(action, Action::Camera(CameraAction::To(_)))));
    let edits = harness.state().log.iter().any(|a| matches!(a, Action::Edit { edit: Edit::Light { .. }, .. }));
    assert!(!edits);
}

#[test]
fn a_click_aims_when_it_is_to_and_escape_gives_that_up() {
    let mut harness = harness();
    harness.state_mut().document.lights = vec![spot()];
    (harness.state_mut().selected_light, harness.state_mut().click_for) = (Some(0), Some(ClickFor::Aim));
    harness.run();
    let place = seen_at(&harness, 1.1, 0.3);
    click(&mut harness, place);
    let aimed =
        harness.state().log.iter().find_map(|a| if let Action::Light(LightAction::Aim(at)) = a { *at } else { None });
    assert!(aimed.unwrap().distance(Vec3::new(1.1, 0.3, 0.0)) < 0.02, "{aimed:?}");
    assert!(!harness.state().log.iter().any(|a| matches!(a, Action::Select(SelectAction::Object(_)))));
    harness.key_press(Key::Escape);
    harness.run();
    assert!(matches!(harness.state().log.last(), Some(Action::Light(LightAction::Aim(None)))));
}
