//! The viewport without a screen: mouse and keys on a synthetic scene.

mod camera;
mod dropping;

use super::{test_window::*, *};
use crate::{actions::SelectAction, document::Edit, test_support::row_of_sources};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, pos2, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;
use lapidary_core::camera::Camera;
use lapidary_render::BrdfSampling;

fn camera(harness: &Harness<App>) -> Camera {
    harness.state().document.camera.clone()
}

fn start() -> Camera {
    App::new().document.camera
}

#[test]
fn a_click_selects_the_object_under_it_and_nothing_beside_it() {
    let mut harness = harness();
    let right = seen_at(&harness, 1.0, 0.2);
    click(&mut harness, right);
    assert_eq!(harness.state().selected, Some(1));
    assert!(matches!(harness.state().log[1], Action::Select(SelectAction::Material(Some(0)))));
    assert_eq!(camera(&harness), start(), "a click does not move the camera");
    wait(&mut harness);
    let left = seen_at(&harness, -1.0, 0.2);
    click(&mut harness, left);
    assert_eq!(harness.state().selected, Some(0));
    wait(&mut harness);
    let between = seen_at(&harness, 0.0, 0.0);
    click(&mut harness, between);
    assert_eq!(harness.state().selected, None);
}

#[test]
fn a_click_with_ctrl_adds_or_takes_away_what_is_under_it_and_nothing_beside_it() {
    let mut harness = harness();
    let [right, between] = [1.0, 0.0].map(|x| seen_at(&harness, x, 0.2));
    for _ in 0..2 {
        click_with(&mut harness, right, Modifiers::COMMAND);
        assert!(
            matches!(harness.state().log[..], [Action::Select(SelectAction::Toggle(1))]),
            "{:?}",
            harness.state().log
        );
        // Without a double click, which would move the camera.
        harness.state_mut().log.clear();
    }
    wait(&mut harness);
    click_with(&mut harness, between, Modifiers::COMMAND);
    assert!(harness.state().log.is_empty(), "{:?}", harness.state().log);
    wait(&mut harness);
    click(&mut harness, between);
    assert!(
        matches!(harness.state().log[0], Action::Select(SelectAction::Object(None))),
        "negative control: without Ctrl"
    );
}

#[test]
fn a_shift_right_drag_turns_what_is_seen_with_the_pointer() {
    let mut harness = harness();
    drag(&mut harness, PointerButton::Secondary, Modifiers::SHIFT, vec2(120.0, 0.0));
    let turned = harness.state().document.environment.rotation().to_degrees();
    assert!((turned + 30.0).abs() < 0.01, "{turned}");
    // The direction ahead is now to the right of the camera, which looks along -Z with +X to its right.
    let ahead = glam::Quat::from_rotation_y(turned.to_radians()) * Vec3::NEG_Z;
    assert!(ahead.x > 0.4);
    let log = &harness.state().log;
    assert!(matches!(log[0], Action::Edit { edit: Edit::Environment(_), label: "Rotate environment" }));
    assert_eq!(log.iter().filter(|action| matches!(action, Action::EndGesture)).count(), 1);
    assert!(matches!(log.last(), Some(Action::EndGesture)));
    assert_eq!(camera(&harness), start());
}

#[test]
fn brackets_turn_the_environment_and_shift_does_so_finely() {
    let mut harness = harness();
    harness.key_press(Key::CloseBracket);
    harness.step();
    assert_eq!(harness.state().document.environment.rotation_degrees, -5.0);
    assert!(matches!(harness.state().log.last(), Some(Action::EndGesture)));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::OpenCurlyBracket);
    harness.step();
    assert_eq!(harness.state().document.environment.rotation_degrees, -4.0);
}

#[test]
fn typing_in_a_text_field_does_not_move_anything() {
    let mut harness = harness();
    harness.get_by_role(Role::TextInput).click();
    harness.step();
    let keys = [Key::OpenBracket, Key::CloseBracket, Key::W];
    for key in keys {
        harness.key_press(key);
    }
    harness.step();
    assert!(harness.state().log.is_empty(), "{:?}", harness.state().log);
    // Negative control: after a press in the viewport the same keys act.
    let center = viewport_center(&harness);
    click(&mut harness, center);
    harness.state_mut().log.clear();
    for key in keys {
        harness.key_press(key);
    }
    harness.step();
    assert!(!harness.state().log.is_empty());
}

#[test]
fn nothing_acts_while_nothing_is_open() {
    let mut harness = harness();
    harness.state_mut().placeholder = Some("Open a scene, or drop one here");
    drag(&mut harness, PointerButton::Primary, Modifiers::NONE, vec2(100.0, 0.0));
    harness.key_press(Key::CloseBracket);
    harness.step();
    assert!(harness.state().log.is_empty());
    harness.get_by_label("Open a scene, or drop one here");
    assert!(harness.query_by_label("Rendering 40 %").is_none());
}

#[test]
fn words_over_the_picture_are_there_and_let_clicks_through() {
    let mut harness = harness();
    harness.get_by_label("Bake is out of date");
    let words = harness.get_by_label("Rendering 40 %").rect();
    click(&mut harness, words.center());
    assert!(matches!(harness.state().log[0], Action::Select(SelectAction::Object(None))));
}

#[test]
fn each_count_mode_has_its_legend_and_the_lit_picture_none() {
    let mut harness = harness();
    let shown = |harness: &Harness<App>, words: &str| {
        let is_text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
            egui::Shape::Text(text) => text.galley.text() == words,
            _ => false,
        };
        harness.output().shapes.iter().any(is_text)
    };
    let title = "Merged cut size, environment";
    assert!(!shown(&harness, title) && !shown(&harness, "1024+"));
    harness.state_mut().document.view.mode = ViewMode::MergedCut;
    harness.step();
    assert!(shown(&harness, title) && shown(&harness, "512+"), "lit cuts are small");
    harness.state_mut().document.view.sampling = BrdfSampling::Refine;
    harness.step();
    assert!(shown(&harness, title) && shown(&harness, "1024+"));
}

#[test]
fn the_size_asked_for_is_in_physical_pixels_and_idling_asks_for_nothing() {
    let mut harness = harness();
    harness.set_pixels_per_point(2.0);
    harness.run_steps(3);
    let response = harness.state().last.unwrap();
    let expected = [response.rect.width() * 2.0, response.rect.height() * 2.0].map(|side| side.round() as u32);
    assert_eq!(response.size_px, expected);
    assert!(harness.run() <= 2, "an idle viewport settles at once");
    assert_eq!(pixels(Rect::from_min_max(pos2(5.0, 5.0), pos2(0.0, f32::NAN)), 1.0), [1, 1]);
}

#[test]
fn clusters_lie_over_the_lit_picture_only() {
    let mut app = App::new();
    app.sources = Some(Arc::new(row_of_sources(4)));
    assert!(app.context().clusters().is_none(), "they are not asked for");
    app.shows_clusters = true;
    for mode in ViewMode::ALL {
        app.document.view.mode = mode;
        assert_eq!(app.context().clusters().is_some(), mode == ViewMode::Shaded, "{mode:?}");
    }
}
