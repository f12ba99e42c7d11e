//! Materials leave the window in the formats of other programs, and come back.

use super::Place;
use crate::actions::Action;
use lapidary_core::{import::load_material, material::BrdfModel};

#[test]
fn materials_are_exported_as_they_are_edited_and_loaded_again() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.pictures.shown().is_some());
    window.type_roughness("0.25");
    for name in ["all.mtlx", "all.mtl", "all.glb", "all.gltf"] {
        window.perform(Action::ExportMaterials(Some(place.path(name))));
        assert!(window.has_said("Materials written") && place.path(name).is_file(), "{name}");
    }
    let selected = window.0.state().selection.material.unwrap_or(0);
    let name = window.0.state().document.materials[selected].name.clone();
    let path = format!("{}#{name}", place.path("all.mtlx").display());
    let read = load_material(path.as_ref(), &mut Default::default(), &Default::default()).unwrap().0;
    assert!((read.parameters.number("specular_roughness") - 0.25).abs() < 1e-6, "{:?}", read.parameters);
    window.perform(Action::LoadMaterial { material: selected, path: Some(place.path("all.mtlx")) });
    window.wait("the material", |s| s.document.materials[selected].model == BrdfModel::OpenPbr);
    window.perform(Action::ExportMaterials(Some(place.path("scene.obj"))));
    assert!(window.has_said("written over an input"));
    window.perform(Action::ExportMaterials(Some(place.path("a.fbx"))));
    assert!(window.has_said("ends in none of .mtlx"));
}
