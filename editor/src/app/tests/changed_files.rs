//! Environments whose files change on disk.

use super::*;
use crate::{actions::EnvironmentAction, document::Edit};
use glam::Vec3;
use lapidary_core::image::Image;

fn write(path: &Path, value: f32) {
    image::write(&Image::filled([8, 4], Vec3::splat(value)), path).unwrap();
}

fn shows(state: &EditorState, value: f32) -> bool {
    state.environments.loaded().is_some_and(|map| map.map.pixels[0] == Vec3::splat(value))
}

#[test]
fn a_changed_environment_is_loaded_as_the_document_asks_for_it() {
    let place = Place::new();
    let path = place.path("sky.exr");
    write(&path, 2.0);
    let mut window = place.window();
    window.perform(Action::Environment(EnvironmentAction::Load(Some(path.clone()))));
    window.wait("the map", |s| shows(s, 2.0));
    assert!(!window.has_said("Reloaded"), "negative control");
    write(&path, 4.0);
    let state = window.0.state_mut();
    state.file_changed(path.clone());
    assert!(state.loader.is_idle(), "the next frame loads it as any map: of several loads the latest counts");
    window.wait("the changed map", |s| shows(s, 4.0));
    assert!(window.has_said("Reloaded"));
    std::fs::write(&path, b"no picture").unwrap();
    window.0.state_mut().file_changed(path.clone());
    window.wait("the attempt", |s| s.loader.is_idle() && !s.environments.reloads);
    assert!(window.has_said("Cannot reload"));
    assert!(shows(window.0.state(), 4.0), "the earlier map stays");
}

#[test]
fn pictures_of_a_changed_map_and_its_layers_are_made_again() {
    let place = Place::new();
    let [sky, other] = ["sky.exr", "other.exr"].map(|name| place.path(name));
    [&sky, &other].into_iter().for_each(|path| write(path, 2.0));
    let mut window = place.window();
    let specs = [sky.clone(), image::with_layer(&sky, "RGBA"), other].map(|path| path.display().to_string());
    let environments = &mut window.0.state_mut().environments;
    for spec in &specs {
        environments.picture(spec);
    }
    window.wait("the pictures", |s| specs.iter().all(|spec| s.environments.pictures.contains_key(spec)));
    let environments = &mut window.0.state_mut().environments;
    environments.reload(&sky);
    environments.pictures.clear();
    for spec in &specs {
        environments.picture(spec);
    }
    window.wait("the new pictures", |s| specs[..2].iter().all(|spec| s.environments.pictures.contains_key(spec)));
    assert!(!window.0.state().environments.pictures.contains_key(&specs[2]), "negative control: of another file");
}

#[test]
fn materials_that_a_changed_file_of_the_scene_names_are_taken_as_a_step_of_undo_and_edits_of_others_stay() {
    let place = Place::new();
    let library = place.path("paint.mtl");
    let paint =
        |red: &str| std::fs::write(&library, format!("newmtl wall\nKd {red} 0 0\nnewmtl door\nKd 0 0 1\n")).unwrap();
    paint("1");
    let quad =
        "mtllib paint.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nusemtl wall\nf 1 3 2\nusemtl door\nf 2 3 4\n";
    std::fs::write(place.path("painted.obj"), quad).unwrap();
    let mut window = place.window();
    window.open(&place.path("painted.obj"));
    let color = |window: &Window, name: &str| {
        let materials = &window.0.state().work.document.materials;
        materials.iter().find(|material| material.name == name).unwrap().parameters.color("base_color")
    };
    assert!(color(&window, "wall").x > 0.5);
    let index = window.0.state().work.document.materials.iter().position(|m| m.name == "door").unwrap();
    let mut door = window.0.state().work.document.materials[index].clone();
    door.parameters.set("base_color", Vec3::Y);
    window.perform(Action::Edit { edit: Edit::Material { index, material: door.into() }, label: "Base color" });
    paint("0.25");
    window.0.state_mut().file_changed(library.clone());
    window.wait("the new color", |s| s.loader.is_idle() && s.work.messages.any_contains("were taken"));
    assert!(color(&window, "wall").x < 0.4 && color(&window, "door") == Vec3::Y, "{}", color(&window, "wall"));
    window.perform(Action::Undo);
    assert!(color(&window, "wall").x > 0.5, "one step back");
    std::fs::write(&library, "newmtl wall\nKd 0.25 0 0\nnewmtl door\nKd 0 0 1\n# a remark\n").unwrap();
    window.0.state_mut().file_changed(library);
    window.wait("the attempt", |s| s.loader.is_idle());
    assert!(color(&window, "wall").x > 0.5, "negative control: the file says what it said before");
}
