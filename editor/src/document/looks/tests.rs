use super::*;
use crate::document::{Edit, History, parts::OwnMaterials};
use glam::Vec3;
use lapidary_core::{
    parts::Part,
    test_scenes::{camera, light},
};

fn named(name: &str) -> Material {
    Material { name: name.into(), ..Default::default() }
}

fn names(of_look: &LookState) -> Vec<&str> {
    of_look.materials.iter().flat_map(|of_look| &of_look.materials).map(|material| material.name.as_str()).collect()
}

/// Two own materials and an added one, which a part has.
fn document() -> Document {
    let materials = ["brass", "wood", "paint"].map(named).to_vec();
    let assigned = [(Part { object: 1, material: 0 }, 2)].into();
    let objects = ["pot", "lid"].map(String::from).to_vec();
    Document { materials, added: 1, assigned, objects, ..Document::empty() }
}

/// A document in which nothing is as in [`document`].
fn other() -> Document {
    let mut other = Document {
        materials: vec![named("gold"), named("oak")],
        added: 0,
        assigned: Assignment::new(),
        lights: vec![light()],
        camera: camera("front"),
        ..document()
    };
    other.environment.rotation_degrees = 90.0;
    other.components.direct = false;
    other.solution = Solution::CutsMeshless;
    other.view.post.exposure = 2.0;
    other
}

#[test]
fn a_look_is_put_in_place_whole_or_in_part_and_one_undo_takes_it_back() {
    let (before, look) = (LookState::of(&document()), LookState::of(&other()));
    for part in [LookPart::All, LookPart::Materials, LookPart::Light, LookPart::Camera] {
        let (mut document, mut history) = (document(), History::new());
        let edit = Edit::Look(look.part(part).into());
        assert!(edit.changes(&document) && edit.fits(&document));
        history.apply(&mut document, edit.clone(), "Look");
        assert!(!edit.changes(&document), "{part:?} is shown");
        let now = LookState::of(&document);
        let taken = |is: LookPart| part == LookPart::All || part == is;
        assert_eq!(now.materials == look.materials, taken(LookPart::Materials));
        assert_eq!(now.light == look.light, taken(LookPart::Light));
        assert_eq!(now.camera == look.camera, taken(LookPart::Camera));
        assert_eq!(now.view == look.view, part == LookPart::All);
        history.undo(&mut document);
        assert_eq!(LookState::of(&document), before);
        history.redo(&mut document);
        assert_eq!(LookState::of(&document), now);
    }
}

#[test]
fn looks_follow_a_ground_that_is_hidden_and_shown() {
    let own = |count, ground| OwnMaterials { count, ground };
    let mut look = LookState::of(&document());
    let shown = Renumbering { before: own(2, None), after: own(3, Some(2)) };
    look.renumber_materials(&shown, &["a", "b", "ground"].map(named));
    assert_eq!(names(&look), ["brass", "wood", "ground", "paint"]);
    let of_look = |look: &LookState| look.materials.clone().unwrap();
    assert_eq!(of_look(&look).assigned[&Part { object: 1, material: 0 }], 3);
    look.materials.as_mut().unwrap().materials[2] = named("sand");
    look.renumber_materials(&Renumbering { before: shown.after, after: shown.before }, &["a", "b"].map(named));
    assert_eq!((names(&look), of_look(&look).hidden_ground), (vec!["brass", "wood", "paint"], Some(named("sand"))));
    look.renumber_materials(&shown, &["a", "b", "ground"].map(named));
    assert_eq!((names(&look), of_look(&look).hidden_ground), (vec!["brass", "wood", "sand", "paint"], None));
}

#[test]
fn looks_have_as_many_materials_as_another_version_of_the_scene() {
    let own = |count| OwnMaterials { count, ground: None };
    let mut look = LookState::of(&document());
    look.renumber_materials(&Renumbering { before: own(2), after: own(3) }, &["a", "b", "new"].map(named));
    assert_eq!(names(&look), ["brass", "wood", "new", "paint"]);
    look.renumber_materials(&Renumbering { before: own(3), after: own(1) }, &["a"].map(named));
    assert_eq!(names(&look), ["brass", "paint"]);
    look.renumber_objects(&ObjectNumbers::between(&["pot", "lid"].map(String::from), &["lid"].map(String::from)));
    let assigned = &look.materials.as_ref().unwrap().assigned;
    assert_eq!(*assigned, [(Part { object: 0, material: 0 }, 1)].into());
}

#[test]
fn a_look_of_other_materials_does_not_fit() {
    let look = LookState::of(&document());
    let larger = Document { materials: ["a", "b", "c", "d"].map(named).to_vec(), ..document() };
    let edit = |part| Edit::Look(look.part(part).into());
    assert!(!edit(LookPart::All).fits(&larger) && edit(LookPart::All).fits(&document()));
    assert!(edit(LookPart::Light).fits(&larger), "which needs no materials");
}

#[test]
fn every_material_is_visited_also_in_steps_of_undo() {
    let (mut document, mut history) = (document(), History::new());
    let look = NamedLook { name: "a".into(), state: LookState::of(&other()) };
    history.apply(&mut document, Edit::Looks(vec![look]), "Add look");
    let edit = Edit::Look(document.looks[0].state.clone().into());
    history.apply(&mut document, edit, "Look");
    let red = |material: &mut Material| material.parameters.set("base_color", Vec3::X);
    document.materials_and_those_of_looks().for_each(|(_, material)| red(material));
    history.visit_materials(&mut |material| red(material));
    let is_red = |state: &LookState| {
        let mut materials = state.materials.iter().flat_map(|of_look| &of_look.materials);
        materials.all(|material| material.parameters.color("base_color") == Vec3::X)
    };
    assert!(is_red(&LookState::of(&document)) && is_red(&document.looks[0].state));
    history.undo(&mut document);
    assert!(document.materials.len() == 3 && is_red(&LookState::of(&document)));
    assert!(!is_red(&LookState::of(&super::tests::document())), "negative control");
}
