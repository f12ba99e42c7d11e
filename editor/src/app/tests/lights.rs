//! Local lights through the whole window: made, moved, undone, saved and found again, written and read.

use super::{EditorState, Place, Window};
use crate::{
    actions::{Action, CameraAction, FileAction, LightAction, SelectAction},
    document::{Component, ComponentSettings, Edit, lights::LightKind},
    workspace::Inspector,
};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use lapidary_core::{camera::Camera, dataset::BakeParts, lights::Light};

fn opened(place: &Place) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window
}

fn lights(window: &Window) -> &[Light] {
    &window.0.state().work.document.lights
}

fn selected(window: &Window) -> Option<usize> {
    window.0.state().work.selected_light()
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.0.key_press_modifiers(modifiers, key);
    window.0.run_steps(3);
}

#[test]
fn lights_are_added_in_view_duplicated_and_deleted_each_as_a_step_of_undo() {
    let place = Place::new();
    let mut window = opened(&place);
    for kind in LightKind::ALL {
        window.perform(Action::Light(LightAction::Add(kind)));
    }
    assert_eq!(selected(&window), Some(3));
    assert!(window.shows("Selected light") && window.shows("Rectangle 1"));
    let camera = &window.0.state().work.document.camera;
    let forward = (camera.target - camera.eye).normalize();
    assert!(lights(&window).iter().all(|l| l.validate().is_ok() && (l.position - camera.eye).dot(forward) > 0.0));
    press(&mut window, Modifiers::COMMAND, Key::D);
    assert_eq!((lights(&window).len(), selected(&window)), (5, Some(4)));
    assert_eq!(lights(&window)[4].name, "Rectangle 2");
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!((lights(&window).len(), selected(&window)), (4, None));
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(lights(&window).len(), 4, "negative control: nothing is selected");
    for left in [5, 4, 3, 2, 1, 0] {
        window.perform(Action::Undo);
        assert_eq!(lights(&window).len(), left);
    }
    assert!(!window.0.state().work.is_modified());
}

#[test]
fn a_drag_in_the_viewport_is_one_step_of_undo() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Light(LightAction::Add(LightKind::Spot)));
    let before = lights(&window)[0].clone();
    // In the middle of the view, so that its disc is where the pointer goes down.
    let mut centred = window.0.state().work.document.camera.clone();
    centred.target = before.position;
    window.perform(Action::Camera(CameraAction::To(centred)));
    let from = window.0.state().interface.viewport_rect.center();
    window.0.drag_at(from);
    window.0.run_steps(2);
    for step in 1..=5 {
        window.0.hover_at(from + egui::vec2(12.0 * step as f32, 5.0));
        window.0.run_steps(1);
    }
    window.0.drop_at(from + egui::vec2(60.0, 5.0));
    window.0.run_steps(3);
    assert!(lights(&window)[0].position.distance(before.position) > 0.02, "it was moved");
    assert_eq!(lights(&window)[0].target, before.target);
    window.perform(Action::Undo);
    assert!(window.shows("Undone: Move light"));
    assert_eq!(lights(&window)[0], before);
}

#[test]
fn lights_switches_and_solo_are_in_the_session() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Light(LightAction::Add(LightKind::Rectangle)));
    window.click("Solo Lights");
    window.click("Switch off Rectangle 1");
    window.perform(Action::File(FileAction::SaveAs(Some(place.path("look.lapidary")))));
    let mut again = place.window();
    again.open(&place.path("look.lapidary"));
    assert_eq!(lights(&again), lights(&window));
    assert!(!lights(&again)[0].enabled);
    let solo = ComponentSettings { solo: Some(Component::Direct), ..Default::default() };
    assert_eq!(again.0.state().work.document.components, solo);
    assert!(!again.0.state().work.is_modified() && selected(&again).is_none());
}

#[test]
fn a_lights_file_is_added_to_the_lights_and_a_bad_one_is_refused() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Light(LightAction::Add(LightKind::Spot)));
    let first = lights(&window)[0].clone();
    window.perform(Action::Light(LightAction::Save(Some(place.path("lights.json")))));
    window.perform(Action::Light(LightAction::Load(Some(place.path("lights.json")))));
    assert_eq!(lights(&window), [first.clone(), first.clone()]);
    assert!(window.has_said("Lights added: 1"));
    window.drop_file(place.path("lights.json"));
    assert_eq!(lights(&window).len(), 3, "dropped lights are added, and are no material");
    window.perform(Action::Undo);
    std::fs::write(place.path("bad.json"), r#"{"lights": [{"kind": "laser", "position": [0, 0, 0]}]}"#).unwrap();
    window.perform(Action::Light(LightAction::Load(Some(place.path("bad.json")))));
    assert!(window.has_said("bad.json") && lights(&window).len() == 2);
    let many = vec![first; lapidary_core::lights::MAX_LIGHTS];
    lapidary_core::lights::LightsFile { lights: many }.write(&place.path("many.json")).unwrap();
    window.perform(Action::Light(LightAction::Load(Some(place.path("many.json")))));
    assert!(window.has_said("4096 lights, not 4098") && lights(&window).len() == 2);
}

#[test]
fn selecting_an_object_lets_go_of_the_light_and_aiming_needs_a_direction() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Light(LightAction::Add(LightKind::Spot)));
    let light = lights(&window)[0].clone();
    window.perform(Action::Light(LightAction::Aim(Some(light.position))));
    assert!(window.has_said("unchanged") && lights(&window)[0] == light);
    window.perform(Action::Light(LightAction::Aim(Some(Vec3::new(0.1, 0.0, 0.2)))));
    assert_eq!(lights(&window)[0].target, Vec3::new(0.1, 0.0, 0.2));
    window.perform(Action::Select(SelectAction::Object(Some(0))));
    assert_eq!(selected(&window), None);
    window.perform(Action::Light(LightAction::Select(Some(0))));
    assert!(selected(&window) == Some(0) && window.0.state().work.selection.object.is_none());
    window.perform(Action::Edit { edit: Edit::Lights(Vec::new()), label: "Delete light" });
    assert_eq!(selected(&window), None, "it is not there any more");
}

#[test]
fn without_bounce_light_the_panel_leads_to_the_bake_of_it() {
    let place = Place::new();
    let mut window = opened(&place);
    window.0.get_by_label("Lights").click();
    window.0.run_steps(3);
    window.click("Bake with bounced light");
    assert_eq!(window.0.state().work.document.bake.mode, BakeParts::CUTS);
    assert_eq!(window.0.state().work.tabs.inspector, Inspector::Bake);
}

#[test]
fn a_black_picture_says_why_and_leads_to_light() {
    let place = Place::new();
    let mut window = opened(&place);
    window.wait("a picture", |s| s.picture.shown().is_some());
    assert!(!window.shows("Nothing gives light") && !window.shows("switched off"), "negative control: the environment");
    window.click("Lights");
    window.click("Solo Lights");
    window.0.state_mut().work.tabs.inspector = Inspector::Material;
    window.0.run_steps(2);
    window.click("Open the Lights tab");
    assert_eq!(window.0.state().work.tabs.inspector, Inspector::Lights);
    window.click("Solo Lights");
    assert!(!window.shows("All light is switched off"));
    let baked = window.0.state().work.scene.baked.as_ref().unwrap();
    let mut dataset = (*baked.dataset).clone();
    dataset.settings.mode = BakeParts::MESHLESS;
    window.0.state_mut().work.scene.baked = Some(dataset.into());
    window.0.run_steps(2);
    assert!(window.shows("Nothing gives light"));
    window.click_containing("Add a light");
    window.click("Spot");
    assert_eq!(lights(&window).len(), 1);
    assert!(!window.shows("Nothing gives light"));
}

#[test]
fn a_new_light_hangs_below_a_ceiling_and_lights_what_is_seen() {
    let place = Place::new();
    // A floor, and a low ceiling over it.
    let quads = "o floor\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 4 3 2\no ceiling\nv -2 0.4 -2\nv 2 0.4 -2\nv 2 0.4 2\nv -2 0.4 2\nf 5 6 7 8\n";
    std::fs::write(place.path("low.obj"), quads).unwrap();
    let mut window = place.window();
    window.open(&place.path("low.obj"));
    let is_ready = |s: &EditorState| s.work.scene.rendered().is_some_and(|b| b.intersector_if_ready().is_some());
    window.wait("rays", is_ready);
    // The target floats behind the floor that is seen.
    let camera = Camera::look_at(Vec3::new(0.0, 0.3, 1.5), Vec3::new(0.0, -0.15, -0.75), 40.0);
    window.perform(Action::Camera(CameraAction::To(camera.clone())));
    window.perform(Action::Light(LightAction::Add(LightKind::Spot)));
    let light = lights(&window).last().unwrap().clone();
    assert!(light.target.y.abs() < 1e-3 && light.target.z.abs() < 1e-2, "on the floor in the middle: {light:?}");
    assert!(light.position.y > 0.01 && light.position.y < 0.4, "below the ceiling: {light:?}");
    let state = window.0.state();
    let baked = state.work.scene.rendered().unwrap();
    let lit = |light: &Light| {
        let view = lapidary_render::View::new(camera.clone(), [64, 48]);
        lapidary_render::lights_view(&baked.dataset, baked.intersector(), light, &view)
    };
    assert!(lit(&light));
    let above = Light { position: Vec3::new(0.0, 0.8, 0.0), ..light };
    assert!(!lit(&above), "negative control: above the ceiling");
}
