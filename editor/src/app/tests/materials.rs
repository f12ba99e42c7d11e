//! Materials leave the window in the formats of other programs, and come back.

use super::Place;
use crate::actions::{Action, ExportAction, MaterialAction};
use egui_kittest::kittest::Queryable;
use lapidary_core::material::{BrdfModel, PRESETS};
use lapidary_interchange::import::load_material;

#[test]
fn materials_are_exported_as_they_are_edited_and_loaded_again() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    window.type_roughness("0.25");
    for name in ["all.mtlx", "all.mtl", "all.glb", "all.gltf"] {
        window.perform(Action::Export(ExportAction::Materials(Some(place.path(name)))));
        assert!(window.has_said("Materials written") && place.path(name).is_file(), "{name}");
    }
    let selected = window.0.state().work.selection.material.unwrap_or(0);
    let name = window.0.state().work.document.materials[selected].name.clone();
    let path = format!("{}#{name}", place.path("all.mtlx").display());
    let read = load_material(path.as_ref(), &mut Default::default(), &Default::default()).unwrap().0;
    assert!((read.parameters.number("specular_roughness") - 0.25).abs() < 1e-6, "{:?}", read.parameters);
    window.perform(Action::Material(MaterialAction::Load { material: selected, path: Some(place.path("all.mtlx")) }));
    window.wait("the material", |s| s.work.document.materials[selected].model == BrdfModel::OpenPbr);
    window.perform(Action::Export(ExportAction::Materials(Some(place.path("scene.obj")))));
    assert!(window.has_said("written over an input"));
    window.perform(Action::Export(ExportAction::Materials(Some(place.path("a.fbx")))));
    assert!(window.has_said("ends in none of .mtlx"));
}

#[test]
fn a_preset_is_dragged_from_its_menu_onto_a_surface_as_a_step_of_undo() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("what is dropped on", |s| s.work.scene.shown().is_some_and(|b| b.intersector_if_ready().is_some()));
    let before = window.0.state().work.document.materials.clone();
    let floor = window.0.get_by_label("Viewport").rect().center();
    // One that is in view without scrolling.
    let preset = &PRESETS[1];
    for (to, is_taken) in [(egui::pos2(2.0, 2.0), false), (floor, true)] {
        window.click("Presets");
        let ball = window.0.get_by_label(preset.name).rect().center();
        window.0.drag_at(ball);
        window.0.step();
        for step in 1..=4 {
            window.0.hover_at(ball + (to - ball) * (step as f32 / 4.0));
            window.0.step();
        }
        window.0.drop_at(to);
        window.0.run_steps(3);
        assert!(!egui::Popup::is_any_open(&window.0.ctx), "the menu closes");
        let taken = window.0.state().work.document.materials[0].parameters == preset.parameters;
        assert_eq!(taken, is_taken, "dropped at {to}");
    }
    assert_eq!(window.0.state().work.selection.material, Some(0));
    window.perform(Action::Undo);
    assert!(window.shows("Undone: Drop preset"));
    assert_eq!(window.0.state().work.document.materials, before, "one step");
}

#[test]
fn a_file_of_several_materials_asks_which() {
    let place = Place::new();
    place.bake();
    let document = r#"<materialx version="1.39">
        <open_pbr_surface name="S1" type="surfaceshader"><input name="specular_roughness" type="float" value="0.5"/></open_pbr_surface>
        <open_pbr_surface name="S2" type="surfaceshader"><input name="specular_roughness" type="float" value="0.125"/></open_pbr_surface>
        <surfacematerial name="gold" type="material"><input name="surfaceshader" nodename="S1"/></surfacematerial>
        <surfacematerial name="steel" type="material"><input name="surfaceshader" nodename="S2"/></surfacematerial>
        </materialx>"#;
    std::fs::write(place.path("all.mtlx"), document).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    let before = window.0.state().work.document.materials.clone();
    for (answer, roughness) in [("Cancel", None), ("steel", Some(0.125)), ("gold", Some(0.5))] {
        window.perform(Action::Material(MaterialAction::Load { material: 0, path: Some(place.path("all.mtlx")) }));
        window.wait("the question", |s| !s.questions.waiting.is_empty());
        assert!(window.shows("Which material?") && window.shows("all.mtlx has 2 materials"));
        window.click(answer);
        window.wait("the answer", |s| s.questions.waiting.is_empty() && s.loader.is_idle());
        let material = &window.0.state().work.document.materials[0];
        match roughness {
            None => assert_eq!(*material, before[0], "negative control"),
            Some(expected) => assert_eq!(material.parameters.number("specular_roughness"), expected),
        }
    }
    for _ in 0..2 {
        window.perform(Action::Undo);
    }
    assert_eq!(window.0.state().work.document.materials, before, "a step each");
}
