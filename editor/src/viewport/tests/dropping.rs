//! Presets and materials dropped on surfaces.

use super::*;
use crate::{
    actions::{MaterialAction, SelectAction},
    dragged::Dragged,
};
use egui::DragAndDrop;
use lapidary_core::{
    material::{Material, PRESETS},
    parts::Part,
};

/// A viewport with the squares of "Right" and "Left" and an unused material, and a drag.
fn dragging(dragged: Dragged) -> Harness<'static, App> {
    let mut harness = harness();
    let named = |name: &str| Material { name: name.into(), double_sided: name == "Left", ..Default::default() };
    let mut gold = named("Gold");
    gold.parameters.set("metalness", 1.0);
    harness.state_mut().document.materials = vec![named("Right"), named("Left"), gold];
    let search = pos2(20.0, 10.0);
    harness.hover_at(search);
    button(&harness, search, PointerButton::Primary, true, Modifiers::NONE);
    harness.step();
    DragAndDrop::set_payload(&harness.ctx, dragged);
    harness.step();
    harness
}

fn hover(harness: &mut Harness<App>, x: f32) -> Pos2 {
    let at = seen_at(harness, x, 0.2);
    harness.hover_at(at);
    harness.step();
    at
}

fn let_go(harness: &mut Harness<App>, at: Pos2) {
    button(harness, at, PointerButton::Primary, false, Modifiers::NONE);
    harness.step();
}

fn edits(harness: &Harness<App>) -> Vec<&'static str> {
    let label = |action: &Action| if let Action::Edit { label, .. } = action { Some(*label) } else { None };
    harness.state().log.iter().filter_map(label).collect()
}

#[test]
fn a_material_that_is_dropped_on_a_surface_gives_its_values_to_the_material_there() {
    let mut harness = dragging(Dragged::Material(2));
    let left = hover(&mut harness, -1.0);
    assert_eq!(harness.state().state.dropping.words(), Some("Gold on Left"));
    assert!(edits(&harness).is_empty(), "nothing changes before it is let go");
    let_go(&mut harness, left);
    let materials = &harness.state().document.materials;
    assert_eq!(materials[1].parameters, materials[2].parameters);
    assert_eq!((materials[1].name.as_str(), materials[1].double_sided), ("Left", true), "name and sides stay");
    assert_eq!(materials[0].parameters.number("metalness"), 0.0, "negative control: the other square");
    assert_eq!(edits(&harness), ["Drop material"]);
    let log = &harness.state().log;
    assert!(matches!(log[0], Action::Select(SelectAction::Object(Some(0)))));
    assert!(matches!(log[1..4], [Action::EndGesture, Action::Edit { .. }, Action::EndGesture]), "a step of its own");
    assert!(matches!(
        log[4..],
        [
            Action::Select(SelectAction::Material(Some(1))),
            Action::Select(SelectAction::Part(Part { object: 0, material: 1 }))
        ]
    ));
    assert_eq!(camera(&harness), start(), "the camera stays");
    assert_eq!(harness.state().state.dropping.words(), None);
}

#[test]
fn a_preset_that_is_dropped_leaves_maps_or_clears_them() {
    for clear_maps in [false, true] {
        let index = PRESETS.iter().position(|preset| preset.name == "Gold").unwrap();
        let mut harness = dragging(Dragged::Preset { index, clear_maps });
        harness.state_mut().document.materials[0].maps.set("roughness", Some(Default::default()));
        let right = hover(&mut harness, 1.0);
        assert_eq!(harness.state().state.dropping.words(), Some("Gold on Right"));
        let_go(&mut harness, right);
        let taken = &harness.state().document.materials[0];
        assert_eq!((&taken.parameters, taken.model), (&PRESETS[index].parameters, PRESETS[index].model));
        assert_eq!(taken.maps.get("roughness").is_none(), clear_maps);
        assert_eq!(edits(&harness), ["Drop preset"]);
    }
}

#[test]
fn with_shift_the_surface_alone_takes_it() {
    let gold = PRESETS.iter().position(|preset| preset.name == "Gold").unwrap();
    let part = Part { object: 0, material: 1 };
    for dragged in [Dragged::Material(2), Dragged::Preset { index: gold, clear_maps: false }] {
        let mut harness = dragging(dragged);
        harness.state_mut().document.objects = vec!["Panel".into()];
        harness.event(Event::ModifiersChanged(Modifiers::SHIFT));
        let left = hover(&mut harness, -1.0);
        assert_eq!(harness.state().state.dropping.words(), Some("Gold on Panel alone"));
        let_go(&mut harness, left);
        assert!(edits(&harness).is_empty(), "its material stays as it is");
        match (dragged, &harness.state().log[1]) {
            (Dragged::Material(_), Action::Material(MaterialAction::Assign { part: taken, material: 2 })) => {
                assert_eq!(*taken, part)
            }
            (
                Dragged::Preset { .. },
                Action::Material(MaterialAction::MakeUnique { part: taken, material: Some(material) }),
            ) => {
                assert_eq!((*taken, material.name.as_str()), (part, "Gold"));
                assert_eq!(material.parameters, PRESETS[gold].parameters);
            }
            (_, other) => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_material_that_a_surface_was_assigned_takes_what_is_dropped() {
    let mut harness = dragging(Dragged::Material(2));
    harness.state_mut().document.assigned = [(Part { object: 0, material: 1 }, 0)].into();
    let left = hover(&mut harness, -1.0);
    let_go(&mut harness, left);
    let metalness = |index: usize| harness.state().document.materials[index].parameters.number("metalness");
    assert_eq!((metalness(0), metalness(1)), (1.0, 0.0));
}

#[test]
fn what_is_dropped_beside_all_surfaces_or_given_up_changes_nothing() {
    let mut harness = dragging(Dragged::Material(2));
    hover(&mut harness, -1.0);
    let between = hover(&mut harness, 0.0);
    assert_eq!(harness.state().state.dropping.words(), Some("Gold"));
    let_go(&mut harness, between);
    assert!(harness.state().log.is_empty(), "{:?}", harness.state().log);
    let mut harness = dragging(Dragged::Material(2));
    let left = hover(&mut harness, -1.0);
    harness.key_press(Key::Escape);
    harness.step();
    let_go(&mut harness, left);
    assert!(edits(&harness).is_empty(), "{:?}", harness.state().log);
}

#[test]
fn what_is_gone_meanwhile_is_not_dropped() {
    let mut harness = dragging(Dragged::Material(2));
    let left = hover(&mut harness, -1.0);
    harness.state_mut().document.materials.pop();
    let_go(&mut harness, left);
    assert!(harness.state().log.is_empty(), "{:?}", harness.state().log);
}
