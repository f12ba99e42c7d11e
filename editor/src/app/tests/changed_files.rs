//! Environments whose files change on disk.

use super::*;
use crate::actions::EnvironmentAction;
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
