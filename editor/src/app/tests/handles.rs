//! Tools chosen by keys, and the objects that have handles.

use super::{Place, Window};
use crate::{
    actions::{Action, CameraAction, LightAction, SelectAction},
    document::{Edit, lights::LightKind},
    viewport::gizmo::{Movable, Tool},
};
use egui::{Event, Key, Modifiers, PointerButton, Popup, Role};
use egui_kittest::kittest::Queryable;
use lapidary_core::{dataset::BakeSettings, ground::Ground};

const FLOOR: u32 = 0;
const PYRAMID: u32 = 1;

fn opened(place: &Place) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    window
}

fn press(window: &mut Window, key: Key) -> Option<Tool> {
    window.0.key_press(key);
    window.0.run_steps(2);
    window.0.state().pose.tool
}

#[test]
fn keys_and_buttons_choose_the_tool_and_r_is_for_the_reference_while_comparing() {
    let place = Place::new();
    let mut window = opened(&place);
    assert_eq!(window.0.state().pose.tool, None);
    let keys = [(Key::W, Some(Tool::Move)), (Key::E, Some(Tool::Turn)), (Key::R, Some(Tool::Scale)), (Key::Q, None)];
    for (key, tool) in keys {
        assert_eq!(press(&mut window, key), tool);
    }
    window.click("Turn tool");
    assert_eq!(window.0.state().pose.tool, Some(Tool::Turn));
    window.0.state_mut().comparison.panel.open = true;
    window.0.run_steps(2);
    assert_eq!(press(&mut window, Key::R), Some(Tool::Turn));
}

/// Shows a ground, and returns its object.
fn show_ground(window: &mut Window) -> u32 {
    let bake = BakeSettings { ground: Ground::On, ..window.0.state().work.document.bake.clone() };
    window.perform(Action::Edit { edit: Edit::Bake(Box::new(bake)), label: "Ground" });
    window.wait("the ground", |s| s.work.scene.rendered().is_some_and(|baked| baked.has_ground()));
    window.0.state().work.scene.ground_object().unwrap()
}

/// Drags the middle of the viewport, at the center of the selection.
fn drag_middle(window: &mut Window) {
    window.perform(Action::Camera(CameraAction::FrameSelection));
    drag_middle_as_it_is(window);
}

fn drag_middle_as_it_is(window: &mut Window) {
    window.0.run_steps(2);
    let from = window.0.state().interface.viewport_rect.center();
    let button = |pos, pressed| {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    };
    let to = from + egui::vec2(60.0, 0.0);
    for event in [Event::PointerMoved(from), button(from, true), Event::PointerMoved(to), button(to, false)] {
        window.0.event(event);
        window.0.step();
    }
    window.0.run_steps(2);
}

#[test]
fn a_drag_in_the_window_is_one_step_of_undo() {
    let place = Place::new();
    let mut window = opened(&place);
    press(&mut window, Key::W);
    window.perform(Action::Select(SelectAction::Object(Some(PYRAMID))));
    drag_middle(&mut window);
    assert!(!window.0.state().work.document.poses.is_as_baked(PYRAMID));
    assert_eq!(window.undo_name().as_deref(), Some("Move pyramid"));
    window.perform(Action::Undo);
    assert!(window.shows("Undone: Move pyramid"));
    assert!(window.0.state().work.document.poses.is_empty());
    assert_eq!(window.undo_name(), None);
}

#[test]
fn a_drag_of_several_objects_is_one_step_of_undo_that_restores_all() {
    let place = Place::new();
    let mut window = opened(&place);
    press(&mut window, Key::W);
    window.perform(Action::Select(SelectAction::Object(Some(FLOOR))));
    window.perform(Action::Select(SelectAction::Toggle(PYRAMID)));
    let moves =
        |window: &Window| [FLOOR, PYRAMID].map(|object| window.0.state().work.document.poses.of(object).translate);
    window.perform(Action::Camera(CameraAction::FrameSelection));
    let eye = window.0.state().work.document.camera.eye;
    let active = movable(&window).unwrap().active.center;
    // Straight before the eye, so that the handles lie in the middle.
    window.0.state_mut().work.document.camera.target = active;
    drag_middle_as_it_is(&mut window);
    assert_eq!(window.0.state().work.document.camera.eye, eye, "no orbit");
    assert_eq!(window.undo_name().as_deref(), Some("Move 2 objects"));
    let [floor, pyramid] = moves(&window);
    assert!(floor.length() > 0.01 && floor == pyramid, "{floor} {pyramid}");
    window.perform(Action::Undo);
    assert!(window.0.state().work.document.poses.is_empty() && window.undo_name().is_none());
    window.perform(Action::Redo);
    assert_eq!(moves(&window), [floor, pyramid]);
}

#[test]
fn a_number_of_several_objects_is_one_step_of_undo_that_restores_all() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Select(SelectAction::Object(Some(FLOOR))));
    window.perform(Action::Select(SelectAction::Toggle(PYRAMID)));
    window.click("Scale value");
    window.0.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.0.get_by_label("Scale value").type_text("2");
    window.0.key_press(Key::Enter);
    window.0.run_steps(3);
    let poses = |window: &Window| [FLOOR, PYRAMID].map(|object| window.0.state().work.document.poses.of(object));
    let scaled = poses(&window);
    assert_eq!(scaled.map(|pose| pose.scale), [2.0, 2.0]);
    // The pyramid's center is 0.3 m above the floor, the pyramid the pivot.
    assert!((scaled[0].translate.y + 0.3).abs() < 1e-5 && scaled[1].translate == glam::Vec3::ZERO, "{scaled:?}");
    window.perform(Action::Undo);
    assert!(window.0.state().work.document.poses.is_empty() && window.undo_name().is_none());
    window.perform(Action::Redo);
    assert_eq!(poses(&window), scaled);
}

#[test]
fn the_ground_and_what_lies_beside_a_selected_light_have_no_handles() {
    let place = Place::new();
    let mut window = opened(&place);
    press(&mut window, Key::W);
    let ground = Some(show_ground(&mut window));
    let of_selected = |window: &mut Window, object| {
        window.perform(Action::Select(SelectAction::Object(object)));
        movable(window).map(|movable| movable.active.object)
    };
    assert_eq!([ground, None].map(|object| of_selected(&mut window, object)), [None, None]);
    assert_eq!(of_selected(&mut window, Some(PYRAMID)), Some(PYRAMID), "negative control");
    window.perform(Action::Light(LightAction::Add(LightKind::Point)));
    assert_eq!(movable(&window), None);
}

/// The selected objects after a press of Escape.
fn after_escape(window: &mut Window) -> Vec<u32> {
    window.0.key_press(Key::Escape);
    window.0.run_steps(3);
    window.0.state().work.selection.objects().collect()
}

#[test]
fn escape_selects_nothing_unless_something_else_takes_it() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Select(SelectAction::Object(Some(FLOOR))));
    window.perform(Action::Select(SelectAction::Toggle(PYRAMID)));
    let both = [PYRAMID, FLOOR];
    window.click("Filter objects and materials");
    assert_eq!(after_escape(&mut window), both, "it leaves the text field");
    for opener in ["File", "View mode tool", "Pivot"] {
        window.0.get_by_role_and_label(role_of(opener), opener).click();
        window.0.run_steps(3);
        assert!(Popup::is_any_open(&window.0.ctx), "{opener}");
        assert_eq!(after_escape(&mut window), both, "it closes what {opener} opened");
        assert!(!Popup::is_any_open(&window.0.ctx), "{opener}");
    }
    window.0.key_press(Key::F1);
    window.0.run_steps(3);
    assert_eq!(after_escape(&mut window), both, "it closes the keyboard map");
    assert!(!window.0.state().interface.keys_open);
    assert_eq!(after_escape(&mut window), [0; 0], "nothing else takes it");
    assert_eq!(window.undo_name(), None);
}

fn role_of(opener: &str) -> Role {
    if opener == "File" { Role::Button } else { Role::ComboBox }
}

#[test]
fn escape_gives_up_a_drag_and_keeps_the_selection() {
    let place = Place::new();
    let mut window = opened(&place);
    press(&mut window, Key::W);
    window.perform(Action::Select(SelectAction::Object(Some(PYRAMID))));
    window.perform(Action::Camera(CameraAction::FrameSelection));
    window.0.run_steps(2);
    let from = window.0.state().interface.viewport_rect.center();
    window.0.drag_at(from);
    window.0.step();
    window.0.hover_at(from + egui::vec2(60.0, 0.0));
    window.0.run_steps(2);
    assert!(!window.0.state().work.document.poses.is_as_baked(PYRAMID), "negative control");
    for press in ["puts it back", "does nothing while the button is held"] {
        assert_eq!(after_escape(&mut window), [PYRAMID], "{press}");
        assert!(window.0.state().work.document.poses.is_empty(), "{press}");
    }
    window.0.drop_at(from + egui::vec2(60.0, 0.0));
    window.0.run_steps(2);
    assert_eq!(after_escape(&mut window), [0; 0]);
}

#[test]
fn clicks_with_ctrl_add_and_take_away_objects_but_not_the_ground() {
    let place = Place::new();
    let mut window = opened(&place);
    let ground = show_ground(&mut window);
    let mut after = |action: Action| {
        window.perform(action);
        window.0.state().work.selection.objects().collect::<Vec<_>>()
    };
    assert_eq!(after(Action::Select(SelectAction::Object(Some(FLOOR)))), [FLOOR]);
    assert_eq!(after(Action::Select(SelectAction::Toggle(PYRAMID))), [PYRAMID, FLOOR]);
    assert_eq!(after(Action::Select(SelectAction::Toggle(ground))), [PYRAMID, FLOOR], "the ground is refused");
    assert_eq!(after(Action::Select(SelectAction::Toggle(FLOOR))), [PYRAMID]);
    assert_eq!(after(Action::Select(SelectAction::Toggle(FLOOR))), [FLOOR, PYRAMID]);
    assert_eq!(after(Action::Select(SelectAction::Object(Some(ground)))), [ground], "a plain click replaces");
    assert_eq!(after(Action::Select(SelectAction::Toggle(PYRAMID))), [PYRAMID], "the ground does not go along");
    assert_eq!(after(Action::Select(SelectAction::Toggle(FLOOR))), [FLOOR, PYRAMID]);
    assert!(after(Action::Light(LightAction::Select(Some(0)))).is_empty());
}

fn movable(window: &Window) -> Option<Movable> {
    let state = window.0.state();
    state.pose.movable(&state.work)
}
