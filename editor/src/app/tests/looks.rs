//! Looks in the window: added, shown, compared, rendered, and kept in the session.

use super::{export::fill, *};
use crate::{
    document::{Edit, looks::LookPart},
    looks::show_look,
    workspace::Side,
};
use egui::Event;
use lapidary_core::material::Material;

/// A window with a scene, the tab of looks, and a first look of it.
fn with_a_look(place: &Place) -> Window {
    place.bake();
    let mut window = place.window_of(vec2(1100.0, 860.0));
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    window.click("Looks");
    assert!(window.shows("A look keeps materials"), "the tab says what it is for");
    window.click("Add look");
    window
}

/// Colors the first material, turns the environment, and looks from elsewhere.
fn change(window: &mut Window, color: glam::Vec3, rotation_degrees: f32) {
    let document = &window.0.state().work.document;
    let mut material: Material = document.materials[0].clone();
    material.parameters.set("base_color", color);
    let environment = crate::document::EnvironmentSettings { rotation_degrees, ..document.environment.clone() };
    let mut camera = document.camera.clone();
    camera.eye += glam::Vec3::Y;
    window.perform(Action::Edit { edit: Edit::Material { index: 0, material: material.into() }, label: "Color" });
    window.perform(Action::Edit { edit: Edit::Environment(environment), label: "Rotation" });
    window.perform(Action::Camera(CameraAction::To(camera)));
}

/// The color of the first material, the rotation of the environment, and the height of the eye.
fn state(window: &Window) -> (glam::Vec3, f32, f32) {
    let document = &window.0.state().work.document;
    let color = document.materials[0].parameters.color("base_color");
    (color, document.environment.rotation_degrees, document.camera.eye.y)
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.0.key_press_modifiers(modifiers, key);
    window.0.run_steps(3);
}

#[test]
fn looks_are_switched_by_their_pictures_and_keys_and_an_undo_leads_back() {
    let place = Place::new();
    let mut window = with_a_look(&place);
    let first = state(&window);
    change(&mut window, glam::Vec3::X, 90.0);
    press(&mut window, Modifiers::SHIFT, Key::L);
    let second = state(&window);
    assert!(first != second && window.0.state().work.document.looks.len() == 2);
    window.wait("pictures of both", |s| {
        let of = |look: usize| s.looks.has_picture(&s.work.document.looks[look].state);
        of(0) && of(1)
    });
    window.click("Show Look 1");
    assert_eq!(state(&window), first);
    assert_eq!(window.undo_name().as_deref(), Some("Look"));
    press(&mut window, Modifiers::ALT, Key::Num2);
    assert_eq!(state(&window), second);
    press(&mut window, Modifiers::ALT, Key::Num9);
    assert_eq!(state(&window), second, "there is no ninth look");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(state(&window), first);
    let material = window.0.state().work.document.materials[0].clone();
    let added = Edit::Added { material: Some(Box::new(material)), assigned: Default::default() };
    window.perform(Action::Edit { edit: added, label: "Add material" });
    let last = window.0.state().work.document.materials.len() - 1;
    window.perform(Action::Select(crate::actions::SelectAction::Material(Some(last))));
    window.click("Show Look 1");
    assert_eq!(window.0.state().work.selection.material, None, "what the look does not have is not selected");
    let parts = show_look(&window.0.state().work.document, 1, LookPart::Light);
    parts.into_iter().for_each(|action| window.perform(action));
    assert_eq!(state(&window), (first.0, second.1, first.2), "only its light");
}

#[test]
fn looks_are_renamed_replaced_deleted_and_kept_in_the_session() {
    let place = Place::new();
    let mut window = with_a_look(&place);
    change(&mut window, glam::Vec3::Y, 30.0);
    let changed = state(&window);
    window.click("More of Look 1");
    window.click("Replace by what is shown");
    window.click("More of Look 1");
    window.click("Rename");
    window.0.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.0.run_steps(2);
    window.0.get_by_label("Look name").type_text("Green");
    window.0.run_steps(2);
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(window.0.state().work.document.looks[0].name, "Green");
    change(&mut window, glam::Vec3::Z, 60.0);
    let session = place.path("looks.lapidary");
    window.perform(Action::File(crate::actions::FileAction::SaveAs(Some(session.clone()))));
    window.click("More of Green");
    window.click("Delete");
    assert!(window.0.state().work.document.looks.is_empty());
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.document.looks[0].name, "Green");

    let mut again = place.window_of(vec2(1100.0, 860.0));
    again.open(&session);
    again.wait("a picture", |s| s.picture.shown().is_some());
    again.0.state_mut().work.tabs.side = Side::Looks;
    again.0.run_steps(2);
    again.click("Show Green");
    assert_eq!(state(&again), changed);
}

#[test]
fn a_look_is_compared_with_what_is_shown() {
    let place = Place::new();
    let mut window = with_a_look(&place);
    let difference = |s: &EditorState| {
        let measured = s.comparison.context().measured?;
        measured.reference.finished.then_some(measured.metrics.rel_rmse)
    };
    window.click("More of Look 1");
    window.click("Compare with it");
    window.wait("the same look", |s| difference(s) == Some(0.0));
    change(&mut window, glam::Vec3::X, 90.0);
    window.wait("another look", |s| difference(s).is_some_and(|difference| difference > 0.05));
    let state = window.0.state();
    let compared = state.comparison.compared(state.work.document.view.cuts(), egui::Color32::RED);
    assert!(compared.labels[1].contains("Look 1"), "its name stands over the picture: {:?}", compared.labels);
    let hold = Event::Key { key: Key::R, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    window.0.input_mut().events.push(hold);
    window.0.run_steps(2);
    assert_eq!(
        window.0.state().comparison.panel.shown_view(),
        crate::viewport::compare::CompareView::Reference,
        "it flickers like any reference"
    );
}

#[test]
fn what_is_shown_is_exported_in_another_size_and_no_file_is_lost() {
    let place = Place::new();
    place.bake();
    let mut window = place.window_of(vec2(1100.0, 860.0));
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    let folder = place.path("out");
    let describe = |window: &mut Window| {
        window.click_containing("File");
        window.click("Export pictures...");
        window.0.run_steps(3);
        for (field, text) in [
            ("Picture width", "24"),
            ("Picture height", "16"),
            ("Folder of the pictures", &folder.display().to_string()),
            ("Name of the pictures", "hero"),
        ] {
            fill(window, field, text);
        }
        window.click("Export");
    };
    describe(&mut window);
    window.wait("the end of the export", |s| !s.exporting.is_running());
    assert_eq!(image::read(&folder.join("hero.png")).unwrap().size, [24, 16]);
    std::fs::write(folder.join("hero.png"), b"mine").unwrap();
    describe(&mut window);
    assert!(window.shows("1 of 1 files are there already"), "and it is not lost");
    assert_eq!(std::fs::read(folder.join("hero.png")).unwrap(), b"mine");
    window.click("Replace existing");
    window.click("Export");
    window.wait("the end of the export", |s| !s.exporting.is_running());
    assert_eq!(image::read(&folder.join("hero.png")).unwrap().size, [24, 16]);
}

#[test]
fn looks_are_rendered_to_files() {
    let place = Place::new();
    let mut window = with_a_look(&place);
    change(&mut window, glam::Vec3::X, 90.0);
    window.click("Add look");
    window.click("Render looks...");
    assert!(window.shows("2 pictures of 1920 x 1080 pixels"));
    // The dialog has its place.
    window.0.run_steps(3);
    let folder = place.path("out");
    for (field, text) in [
        ("Picture width", "24"),
        ("Picture height", "16"),
        ("Picture samples", "1"),
        ("Folder of the pictures", &folder.display().to_string()),
    ] {
        fill(&mut window, field, text);
    }
    window.click("PNG");
    window.click("Export");
    assert!(window.shows("no format is chosen"), "the dialog says why it does not begin");
    window.click("PNG");
    window.click("Export");
    window.wait("the end of the export", |s| !s.exporting.is_running());
    assert!(window.has_said("2 pictures written"));
    let read = |name: &str| image::read(&folder.join(name)).unwrap();
    assert_eq!(read("scene-Look 1.png").size, [24, 16]);
    assert_ne!(read("scene-Look 1.png"), read("scene-Look 2.png"));
}
