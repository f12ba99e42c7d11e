//! Which tool the keys choose, and what has handles.

use super::{Place, Window};
use crate::{
    actions::Action,
    app::layout::movable,
    document::{Edit, lights::LightKind},
    viewport::gizmo::Tool,
};
use egui::{Event, Key, Modifiers, PointerButton};
use lapidary_core::{dataset::BakeSettings, ground::Ground};

const PYRAMID: u32 = 1;

fn opened(place: &Place) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.pictures.shown().is_some());
    window
}

fn press(window: &mut Window, key: Key) -> Option<Tool> {
    window.0.key_press(key);
    window.0.run_steps(2);
    window.0.state().interface.tool
}

#[test]
fn keys_and_buttons_choose_the_tool_and_r_is_for_the_reference_while_comparing() {
    let place = Place::new();
    let mut window = opened(&place);
    assert_eq!(window.0.state().interface.tool, None);
    let keys = [(Key::W, Some(Tool::Move)), (Key::E, Some(Tool::Turn)), (Key::R, Some(Tool::Scale)), (Key::Q, None)];
    for (key, tool) in keys {
        assert_eq!(press(&mut window, key), tool);
    }
    window.click("Turn tool");
    assert_eq!(window.0.state().interface.tool, Some(Tool::Turn));
    window.0.state_mut().interface.comparison.open = true;
    window.0.run_steps(2);
    assert_eq!(press(&mut window, Key::R), Some(Tool::Turn));
}

/// Drags the middle of the viewport, where the centre of what is selected is seen.
fn drag_middle(window: &mut Window) {
    window.perform(Action::FrameSelection);
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
    window.perform(Action::SelectObject(Some(PYRAMID)));
    drag_middle(&mut window);
    assert!(!window.0.state().document.poses.is_as_baked(PYRAMID));
    assert_eq!(window.0.state().history.undo_label(), Some("Move object"));
    window.perform(Action::Undo);
    assert!(window.0.state().document.poses.is_empty());
    assert_eq!(window.0.state().history.undo_label(), None);
}

#[test]
fn the_ground_and_what_lies_beside_a_selected_light_have_no_handles() {
    let place = Place::new();
    let mut window = opened(&place);
    press(&mut window, Key::W);
    let bake = BakeSettings { ground: Ground::On, ..window.0.state().document.bake.clone() };
    window.perform(Action::Edit { edit: Edit::Bake(Box::new(bake)), label: "Ground" });
    window.wait("the ground", |s| s.scene.rendered().is_some_and(|baked| baked.has_ground()));
    let of_selected = |window: &mut Window, object| {
        window.perform(Action::SelectObject(object));
        movable(window.0.state()).map(|movable| movable.object)
    };
    let ground = window.0.state().scene.rendered().and_then(|baked| baked.dataset.scene.mesh.ground_object());
    assert!(ground.is_some_and(|ground| ground != PYRAMID));
    assert_eq!([ground, None].map(|object| of_selected(&mut window, object)), [None, None]);
    assert_eq!(of_selected(&mut window, Some(PYRAMID)), Some(PYRAMID), "negative control");
    window.perform(Action::AddLight(LightKind::Point));
    assert_eq!(movable(window.0.state()), None);
}
