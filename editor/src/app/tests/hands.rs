//! Keys and clicks land where they should: in fields, in commands, in popups.

use super::{NONE, Place, Window};
use crate::{
    actions::{Action, CameraAction},
    document::{Edit, ViewSettings},
};
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::Queryable;
use lapidary_core::camera::Camera;

fn opened(place: &Place) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    // A camera that no command leads to.
    let camera = Camera { eye: glam::Vec3::new(0.3, 2.0, 0.4), ..window.0.state().work.document.camera.clone() };
    window.perform(Action::Camera(CameraAction::To(camera)));
    window.wait("what clicks meet", |s| s.work.scene.shown().is_some_and(|b| b.intersector_if_ready().is_some()));
    window
}

/// A key down and up.
fn press(modifiers: Modifiers, key: Key) -> [Event; 2] {
    [true, false].map(|pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers })
}

fn typed(text: &str) -> Vec<Event> {
    let events = |letter: char| {
        let key = Key::from_name(&letter.to_ascii_uppercase().to_string()).unwrap();
        let [down, up] = press(NONE, key);
        [down, Event::Text(letter.to_string()), up]
    };
    text.chars().flat_map(events).collect()
}

pub fn click(position: Pos2) -> [Event; 3] {
    let button = |pressed| {
        let button = PointerButton::Primary;
        Event::PointerButton { pos: position, button, pressed, modifiers: NONE }
    };
    [Event::PointerMoved(position), button(true), button(false)]
}

impl Window {
    /// Sends events in one frame, and runs the frames after it.
    pub fn frame_of(&mut self, events: impl IntoIterator<Item = Event>) {
        self.0.input_mut().events.extend(events);
        self.0.run_steps(3);
    }

    fn camera(&self) -> Camera {
        self.0.state().work.document.camera.clone()
    }
}

#[test]
fn a_hex_color_typed_fast_changes_the_color_alone() {
    let place = Place::new();
    let mut window = opened(&place);
    let (camera, view) = (window.camera(), window.0.state().work.document.view.clone());
    let field = window.0.get_by_label("Base color hex").rect().center();
    // The last letters, the key that leaves the field and the keys typed blindly after it arrive together.
    window.frame_of(click(field).into_iter().chain(typed("fa")));
    window.0.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.0.run_steps(2);
    window.frame_of(typed("ffaa00").into_iter().chain(press(NONE, Key::Enter)).chain(typed("fa1")));
    assert_eq!((window.camera(), &window.0.state().work.document.view), (camera.clone(), &view));
    let color = window.0.state().work.document.materials[0].parameters.color("base_color");
    assert!(color.distance(glam::Vec3::new(1.0, 0.402, 0.0)) < 0.01, "{color}");
    window.frame_of(typed("fa1"));
    assert_ne!(window.camera(), camera, "negative control: no field has the focus");
}

#[test]
fn ten_presses_in_one_frame_undo_ten_times() {
    let place = Place::new();
    let mut window = opened(&place);
    let revised = |window: &Window| window.0.state().work.document.view.post.exposure;
    for step in 1..=12 {
        let mut view: ViewSettings = window.0.state().work.document.view.clone();
        view.post.exposure = step as f32;
        window.perform(Action::Edit { edit: Edit::View(view), label: "Exposure" });
        window.perform(Action::EndGesture);
    }
    window.frame_of(vec![press(Modifiers::COMMAND, Key::Z); 10].concat());
    assert_eq!(revised(&window), 2.0);
    window.frame_of(vec![press(Modifiers::COMMAND, Key::Y); 7].concat());
    assert_eq!(revised(&window), 9.0);
    let wireframe = |window: &Window| window.0.state().work.document.view.wireframe;
    window.frame_of([press(Modifiers::SHIFT, Key::W), press(Modifiers::SHIFT, Key::W)].concat());
    assert!(!wireframe(&window), "two presses of a switch");
    window.frame_of(press(Modifiers::SHIFT, Key::W));
    assert!(wireframe(&window));
}

#[test]
fn a_click_that_closes_a_menu_or_a_list_does_nothing_else() {
    let place = Place::new();
    let mut window = opened(&place);
    window.0.state_mut().work.selection.object = None;
    let floor = window.0.get_by_label("Viewport").rect().center();
    let wireframe = window.0.get_by_label("Wireframe").rect().center();
    for opener in ["File", "View mode tool", "Presets"] {
        window.0.get_by_label(opener).click();
        window.0.run_steps(3);
        assert!(egui::Popup::is_any_open(&window.0.ctx), "{opener}");
        window.frame_of(click(if opener == "View mode tool" { wireframe } else { floor }));
        assert!(!egui::Popup::is_any_open(&window.0.ctx), "{opener}");
        assert_eq!(window.0.state().work.selection.object, None, "{opener}");
        assert!(!window.0.state().work.document.view.wireframe, "{opener}");
    }
    window.frame_of(click(floor));
    assert!(window.0.state().work.selection.object.is_some(), "negative control: nothing is open");
    window.frame_of(click(wireframe));
    assert!(window.0.state().work.document.view.wireframe);
}

#[test]
fn the_pointer_still_goes_from_menu_to_menu() {
    let place = Place::new();
    let mut window = opened(&place);
    window.click("File");
    assert!(window.shows("Save as"));
    let next = window.0.get_by_label("Edit").rect().center();
    window.0.hover_at(next);
    window.0.run_steps(3);
    assert!(window.shows("Duplicate light") && !window.shows("Save as"));
}

#[test]
fn a_click_that_closes_a_dialog_selects_nothing() {
    let place = Place::new();
    let mut window = opened(&place);
    window.0.state_mut().work.selection.object = None;
    let viewport = window.0.get_by_label("Viewport").rect();
    let beside = viewport.left_bottom() + egui::vec2(6.0, -6.0);
    window.0.key_press(Key::F1);
    window.0.run_steps(3);
    // For the dialog, even before the toolkit knows of it.
    window.frame_of(press(NONE, Key::Num2));
    assert!(window.shows("Keyboard and pointer"));
    let camera = window.camera();
    window.frame_of(click(beside));
    assert!(!window.shows("Keyboard and pointer"));
    assert_eq!((window.0.state().work.selection.object, window.camera()), (None, camera));
    assert_eq!(window.0.state().work.document.view.mode, lapidary_render::ViewMode::Shaded);
}

#[test]
fn a_dialog_that_a_key_opens_has_the_keys_at_once() {
    let place = Place::new();
    let mut window = opened(&place);
    let camera = window.camera();
    window.0.input_mut().events.extend([press(Modifiers::COMMAND, Key::O), press(NONE, Key::A)].concat());
    window.0.step();
    window.frame_of([press(NONE, Key::A), press(NONE, Key::Num2)].concat());
    assert_eq!(window.camera(), camera);
    assert_eq!(window.0.state().work.document.view.mode, lapidary_render::ViewMode::Shaded);
}

#[test]
fn the_reference_flickers_by_its_key_and_not_by_typing() {
    let place = Place::new();
    let mut window = opened(&place);
    window.0.state_mut().comparison.panel.open = true;
    window.0.run_steps(2);
    let field = window.0.get_by_label("Filter objects and materials").rect().center();
    window.frame_of(click(field));
    window.0.key_down(Key::R);
    window.0.run_steps(2);
    window.frame_of(press(NONE, Key::Enter));
    assert!(!window.0.state().comparison.panel.flicker, "the letter was typed");
    window.0.key_up(Key::R);
    window.0.run_steps(2);
    window.0.key_down(Key::R);
    window.0.run_steps(2);
    assert!(window.0.state().comparison.panel.flicker, "negative control");
    window.0.key_up(Key::R);
    window.0.run_steps(2);
    assert!(!window.0.state().comparison.panel.flicker);
}

#[test]
fn labels_are_no_text_to_select_but_figures_are() {
    let place = Place::new();
    let window = opened(&place);
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        assert!(!window.0.ctx.style_of(theme).interaction.selectable_labels, "{theme:?}");
    }
}
