//! Parts get materials of their own, and variants, without a bake.

use super::{Place, Window};
use crate::{
    actions::{Action, BakeAction, FileAction, MaterialAction, SelectAction},
    app::state::EditorState,
    document::Edit,
};
use glam::{Vec2, Vec3};
use lapidary_core::{dataset::BakeSettings, ground::Ground, material::Material, parts::Part};
use std::sync::Arc;

const PYRAMID: Part = Part { object: 1, material: 0 };

fn opened(place: &Place) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    wait_for_picture(&mut window);
    window
}

fn wait_for_picture(window: &mut Window) {
    window.wait("the whole picture", |s| s.picture.shown().is_some_and(|p| p.samples == p.of_samples));
}

/// The share of the picture that is red.
fn red(state: &EditorState) -> f32 {
    let Some(shown) = state.picture.shown() else { return 0.0 };
    let is_red = |[r, g, b, _]: &&[u8; 4]| *r > 60 && r / 3 > *g && r / 3 > *b;
    shown.pixels.iter().filter(is_red).count() as f32 / shown.pixels.len() as f32
}

fn wait_for_red(window: &mut Window, expected: bool) {
    window.wait("another picture", |s| (red(s) > 0.005) == expected);
}

fn paint(window: &mut Window, index: usize, color: Vec3) {
    let mut material: Material = window.0.state().work.document.materials[index].clone();
    material.parameters.set("base_color", color);
    let edit = Edit::Material { index, material: Box::new(material) };
    window.perform(Action::Edit { edit, label: "Base color" });
    window.perform(Action::EndGesture);
}

const RED: Vec3 = Vec3::new(0.9, 0.01, 0.01);

#[test]
fn a_part_gets_a_material_of_its_own_without_a_bake_and_sessions_keep_it() {
    let place = Place::new();
    let mut window = opened(&place);
    let before = window.0.state().work.document.clone();
    let baked = window.0.state().work.scene.shown().unwrap().dataset.clone();
    window.perform(Action::Select(SelectAction::Object(Some(1))));
    window.click("Make unique");
    let state = window.0.state();
    assert_eq!(
        (state.work.document.materials.len(), state.work.selection.material),
        (before.materials.len() + 1, Some(1))
    );
    assert_eq!(state.work.document.material_of(PYRAMID), 1);
    assert_eq!(red(window.0.state()), 0.0);
    paint(&mut window, 1, RED);
    wait_for_red(&mut window, true);
    wait_for_picture(&mut window);
    assert!(red(window.0.state()) < 0.4, "negative control: the floor stays as it is");
    let state = window.0.state();
    assert!(Arc::ptr_eq(&baked, &state.work.scene.shown().unwrap().dataset) && state.baking.progress().is_none());

    let session = place.path("look.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    let mut again = place.window();
    again.open(&session);
    assert_eq!(again.0.state().work.document.material_of(PYRAMID), 1);
    wait_for_red(&mut again, true);

    window.perform(Action::Material(MaterialAction::Assign { part: PYRAMID, material: 0 }));
    wait_for_red(&mut window, false);
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.selection.material, Some(1), "what the panel edits is the part's");
    for _ in 0..2 {
        window.perform(Action::Undo);
    }
    assert_eq!(window.0.state().work.selection.material, Some(0));
    let document = &window.0.state().work.document;
    assert_eq!((&document.materials, document.added, &document.assigned), (&before.materials, 0, &before.assigned));
    for _ in 0..2 {
        window.perform(Action::Redo);
    }
    wait_for_red(&mut window, true);
}

#[test]
fn a_bake_takes_the_opacity_of_a_part_with_a_material_of_its_own() {
    let place = Place::new();
    let mut window = opened(&place);
    let words = "Opacity was edited; bake again to update its shadows";
    window.perform(Action::Material(MaterialAction::MakeUnique { part: PYRAMID, material: None }));
    window.0.run_ok();
    assert!(!window.shows(words), "negative control: nothing lets light through");
    let mut glass = window.0.state().work.document.materials[1].clone();
    glass.parameters.set("geometry_opacity", 0.25);
    let edit = Edit::Material { index: 1, material: Box::new(glass) };
    window.perform(Action::Edit { edit, label: "Opacity" });
    window.perform(Action::EndGesture);
    assert!(window.shows(words));
    window.0.state_mut().work.document.bake.lights = 512;
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    window.wait("the bake", |s| s.baking.progress().is_none());
    wait_for_picture(&mut window);
    assert!(!window.shows(words));
    let scene = &window.0.state().work.scene.shown().unwrap().dataset.scene;
    let opacity = |part| scene.opacity_of(part).at([Vec2::ZERO; 2]);
    assert_eq!([opacity(PYRAMID), opacity(Part { object: 0, material: 0 })], [0.25, 1.0]);

    let mut again = place.window();
    again.open(&place.path("scene.cuts"));
    wait_for_picture(&mut again);
    assert!(!again.shows(words));
    let document = &again.0.state().work.document;
    assert_eq!((document.added, document.material_of(PYRAMID)), (1, 1));
    window.perform(Action::Material(MaterialAction::Assign { part: PYRAMID, material: 0 }));
    window.0.run_ok();
    assert!(window.shows(words), "the bake still lets light through");
}

#[test]
fn a_material_that_was_added_stays_that_of_its_part_while_a_ground_comes_and_goes() {
    let place = Place::new();
    let mut window = opened(&place);
    window.perform(Action::Material(MaterialAction::MakeUnique { part: PYRAMID, material: None }));
    paint(&mut window, 1, Vec3::X);
    let color = |state: &EditorState| {
        let material = state.work.document.material_of(PYRAMID);
        state.work.document.materials[material].parameters.color("base_color")
    };
    let choose = |window: &mut Window, ground| {
        let bake = BakeSettings { ground, ..window.0.state().work.document.bake.clone() };
        window.perform(Action::Edit { edit: Edit::Bake(Box::new(bake)), label: "Ground" });
        window.perform(Action::EndGesture);
    };
    choose(&mut window, Ground::On);
    let state = window.0.state();
    assert_eq!(state.work.document.materials[1].name, "Ground");
    assert_eq!(
        (color(state), state.work.document.material_of(PYRAMID), state.work.selection.material),
        (Vec3::X, 2, Some(2))
    );
    let ground = Part { object: 2, material: 1 };
    for refused in [
        Action::Material(MaterialAction::Assign { part: PYRAMID, material: 1 }),
        Action::Material(MaterialAction::Assign { part: ground, material: 0 }),
        Action::Material(MaterialAction::MakeUnique { part: ground, material: None }),
        Action::Material(MaterialAction::Assign { part: PYRAMID, material: 9 }),
    ] {
        window.perform(refused.clone());
        let document = &window.0.state().work.document;
        assert_eq!((document.assigned.len(), document.materials.len()), (1, 3), "{refused:?}");
    }
    choose(&mut window, Ground::Off);
    assert_eq!((color(window.0.state()), window.0.state().work.document.materials.len()), (Vec3::X, 2));
    for _ in 0..3 {
        window.perform(Action::Undo);
    }
    assert_ne!(color(window.0.state()), Vec3::X, "the edit of before finds its material");
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.document.added, 0);
}

#[test]
fn a_surface_that_has_a_material_alone_already_takes_the_values_of_others() {
    let place = Place::new();
    let mut window = opened(&place);
    let gold = Material { name: "Gold".into(), ..Default::default() };
    for roughness in [0.25, 0.5] {
        let mut material = gold.clone();
        material.parameters.set("roughness", roughness);
        window.perform(Action::Material(MaterialAction::MakeUnique { part: PYRAMID, material: Some(material.into()) }));
        let document = &window.0.state().work.document;
        assert_eq!((document.materials.len(), document.materials[1].name.as_str()), (2, "Gold"));
        assert_eq!(document.materials[1].parameters.number("roughness"), roughness);
    }
    window.perform(Action::Material(MaterialAction::MakeUnique { part: PYRAMID, material: None }));
    assert_eq!(window.undo_name().as_deref(), Some("Make unique"));
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.document.materials[1].parameters.number("roughness"), 0.25, "one step each");
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.document.materials.len(), 1);
}

/// A floor that is leather or suede.
const SHOE: &str = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_variants"],
    "extensions": {"KHR_materials_variants": {"variants": [{"name": "plain"}, {"name": "painted"}]}},
    "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "shoe"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions": {"KHR_materials_variants":
        {"mappings": [{"material": 0, "variants": [0]}, {"material": 1, "variants": [1]}]}}}]}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "materials": [{"name": "leather"}, {"name": "suede", "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.01, 0.01, 1]}}]}"#;

#[test]
fn a_variant_is_chosen_in_the_window_without_a_bake_as_a_step_of_undo() {
    let place = Place::new();
    std::fs::write(place.path("shoe.gltf"), SHOE).unwrap();
    let mut window = place.window();
    window.open(&place.path("shoe.gltf"));
    wait_for_picture(&mut window);
    assert_eq!(red(window.0.state()), 0.0);
    window.click("Variant");
    window.click("painted");
    let part = Part { object: 0, material: 0 };
    assert_eq!(window.0.state().work.document.material_of(part), 1);
    assert!(window.0.state().baking.progress().is_none());
    wait_for_red(&mut window, true);
    window.0.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.0.run_steps(2);
    assert!(window.shows("Undone: Variant") && window.0.state().work.document.assigned.is_empty());
    window.perform(Action::Material(MaterialAction::ChooseVariant(Some(7))));
    assert!(window.0.state().work.document.assigned.is_empty(), "one that is not there");
}
