use super::*;
use crate::{
    document::Edit,
    test_support::{WIDTH, assert_fits, baked_triangle},
};
use egui::{Key, Modifiers, accesskit::Toggled};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    parts::{PartVariants, Variants},
    scene::{Object, pose::Pose},
};

struct Probe {
    document: Document,
    dataset: Dataset,
    panel: ScenePanel,
    others: Vec<u32>,
    actions: Vec<Action>,
}

fn named(names: &[&str]) -> Dataset {
    let mut dataset = baked_triangle();
    dataset.scene.objects = names.iter().map(|n| Object { name: (*n).into() }).collect();
    dataset
}

fn panel(dataset: Dataset, bookmarks: &[&str]) -> Harness<'static, Probe> {
    let mut document = Document::empty();
    document.materials = vec![Material { name: "Gold".into(), ..Default::default() }, Material::default()];
    document.bookmarks = bookmarks.iter().map(|n| Camera { name: (*n).into(), ..document.camera.clone() }).collect();
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let Probe { document, dataset, panel, others, actions } = probe;
        let (selected_object, dataset) = (Some(0), Some(&*dataset));
        let context =
            SceneContext { document, dataset, selected_object, other_objects: others, selected_material: None };
        show(ui, panel, &context, actions);
    };
    let probe = Probe { document, dataset, panel: ScenePanel::default(), others: Vec::new(), actions: Vec::new() };
    // Steps short enough that two clicks are a double click.
    let builder = Harness::builder().with_size(vec2(WIDTH, 700.0)).with_step_dt(0.02).with_max_steps(60);
    let mut panel = builder.build_ui_state(show, probe);
    panel.run();
    assert!(panel.state().actions.is_empty(), "showing asks for nothing");
    assert_fits(&panel, WIDTH);
    panel
}

/// The names of the bookmarks that were asked for last.
fn bookmarks_asked(panel: &Harness<Probe>) -> Option<Vec<String>> {
    panel.state().actions.iter().rev().find_map(|action| match action {
        Action::Edit { edit: Edit::Bookmarks(cameras), .. } => Some(cameras.iter().map(|c| c.name.clone()).collect()),
        _ => None,
    })
}

#[test]
fn the_pose_of_the_selected_object_is_typed_and_reset() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    assert!(panel.query_by_label("Reset pose").is_none(), "negative control: the document has no objects");
    panel.state_mut().document.objects = vec!["Floor".into(), "Teapot".into()];
    panel.run();
    let typed = |panel: &mut Harness<Probe>, entry: &str, text: &str| {
        panel.state_mut().actions.clear();
        panel.get_by_label(entry).click();
        panel.run();
        panel.get_by_label(entry).type_text(text);
        panel.key_press(Key::Enter);
        panel.run();
        panel.state().actions.iter().find_map(|action| match action {
            Action::Edit { edit: Edit::Poses(poses), .. } if poses.len() == 1 => poses.get(&0).copied(),
            _ => None,
        })
    };
    let moved = typed(&mut panel, "Move Y", "1.5").unwrap();
    assert_eq!(moved, Pose { translate: Vec3::Y * 1.5, ..Pose::AS_BAKED });
    assert_eq!(typed(&mut panel, "Turn Z", "90").unwrap().rotate_degrees, Vec3::Z * 90.0);
    assert_eq!(typed(&mut panel, "Scale value", "2").unwrap().scale, 2.0);
    panel.state_mut().document.poses.set(0, moved);
    panel.state_mut().actions.clear();
    panel.run();
    assert_eq!(reset(&mut panel), [(0, Pose::AS_BAKED)]);
}

/// The poses that a click on *Reset pose* asks for.
fn reset(panel: &mut Harness<Probe>) -> Vec<(u32, Pose)> {
    panel.get_by_label("Reset pose").click();
    panel.run();
    match &panel.state().actions[..] {
        [Action::Edit { edit: Edit::Poses(poses), .. }, Action::EndGesture] => {
            poses.iter().map(|(&o, &p)| (o, p)).collect()
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn all_selected_objects_are_reset_and_their_pivot_is_chosen() {
    let mut panel = panel(named(&["Floor", "Pot", "Lid"]), &[]);
    panel.state_mut().document.objects = ["Floor", "Pot", "Lid"].map(String::from).to_vec();
    panel.state_mut().document.poses.set(2, Pose { scale: 2.0, ..Pose::AS_BAKED });
    panel.run();
    assert!(panel.query_by_label("Pivot").is_none(), "of one object there is no choice");
    panel.state_mut().others = vec![2];
    panel.run();
    assert_fits(&panel, WIDTH);
    assert_eq!(reset(&mut panel), [(0, Pose::AS_BAKED), (2, Pose::AS_BAKED)]);
    assert_eq!(panel.state().panel.pivot, Pivot::Active);
    panel.get_by_role_and_label(Role::ComboBox, "Pivot").click();
    panel.run();
    panel.get_by_label("Each").click();
    panel.run();
    assert_eq!(panel.state().panel.pivot, Pivot::Own);
}

#[test]
fn a_click_with_ctrl_adds_an_object_and_selected_rows_say_so() {
    let mut panel = panel(named(&["Floor", "Pot", "Lid"]), &[]);
    panel.state_mut().others = vec![2];
    panel.run();
    let toggled = ["Floor", "Pot", "Lid"].map(|name| panel.get_by_label(name).accesskit_node().toggled());
    assert_eq!(toggled.map(|toggled| toggled == Some(Toggled::True)), [true, false, true]);
    panel.get_by_label("Pot").click_modifiers(Modifiers::COMMAND);
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::ToggleObject(1)]), "{:?}", panel.state().actions);
}

#[test]
fn clicks_select_objects_and_materials() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    panel.get_by_label("Teapot").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::SelectObject(Some(1))]));
    panel.state_mut().actions.clear();
    panel.get_by_label("Gold").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::SelectMaterial(Some(0))]));
    panel.state_mut().actions.clear();
    panel.get_by_label("Material 2").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::SelectMaterial(Some(1))]));
}

#[test]
fn an_object_shows_its_materials_only() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    assert!(panel.query_by_label("Gold of Teapot").is_none(), "the only triangle belongs to the floor");
    panel.get_by_label("Gold of Floor").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::SelectMaterial(Some(0))]));
}

#[test]
fn a_filter_hides_what_does_not_match() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    panel.get_by_label("Filter objects and materials").click();
    panel.run();
    panel.get_by_label("Filter objects and materials").type_text("TEA");
    panel.run();
    assert!(panel.query_by_label("Teapot").is_some());
    assert!(panel.query_by_label("Floor").is_none() && panel.query_by_label("Gold").is_none());
}

#[test]
fn of_thousands_of_objects_only_those_in_view_are_laid_out() {
    let names: Vec<String> = (0..5000).map(|i| format!("Object number {i}")).collect();
    let panel = panel(named(&names.iter().map(String::as_str).collect::<Vec<_>>()), &[]);
    let rows = panel.query_all_by_label_contains("Object number").count();
    assert_eq!(rows, 11, "the list scrolls");
}

#[test]
fn what_adds_a_view_stands_still_while_the_list_grows() {
    let place = |bookmarks: &[&str]| panel(named(&["Floor"]), bookmarks).get_by_label("Add view").rect();
    assert_eq!(place(&[]), place(&["View 1", "View 2"]));
}

#[test]
fn a_bookmark_is_gone_to_added_and_deleted() {
    let mut panel = panel(named(&["Floor"]), &["View 1", "Close"]);
    panel.get_by_label("Close").click();
    panel.run();
    assert!(matches!(&panel.state().actions[..], [Action::Camera(c)] if c.name == "Close"));
    panel.get_by_label("Add view").click();
    panel.run();
    assert_eq!(bookmarks_asked(&panel).expect("an edit"), ["View 1", "Close", "View 2"]);
    panel.get_by_label("Delete View 1").click();
    panel.run();
    assert_eq!(bookmarks_asked(&panel).expect("an edit"), ["Close"]);
}

#[test]
fn a_double_click_renames_and_escape_does_not() {
    for (key, expected) in [(Key::Enter, Some(vec!["Far".to_owned()])), (Key::Escape, None)] {
        let mut panel = panel(named(&["Floor"]), &["Close"]);
        panel.get_by_label("Close").click();
        panel.get_by_label("Close").click();
        panel.run();
        panel.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
        panel.get_by_label("View name").type_text("Far");
        panel.run();
        panel.key_press(key);
        panel.run();
        assert_eq!(bookmarks_asked(&panel), expected, "{key:?}");
        assert!(panel.query_by_label("View name").is_none());
    }
}

#[test]
fn cameras_of_the_scene_are_there_but_not_to_be_deleted() {
    let mut dataset = named(&["Floor"]);
    dataset.scene.cameras = vec![Camera { name: "Hero".into(), ..Camera::look_at(Vec3::Z, Vec3::ZERO, 30.0) }];
    let mut panel = panel(dataset, &[]);
    assert!(panel.query_by_label("Delete Hero").is_none());
    panel.get_by_label("Hero").click();
    panel.run();
    assert!(matches!(&panel.state().actions[..], [Action::Camera(c)] if c.name == "Hero"));
}

#[test]
fn a_material_can_be_dragged_and_an_object_cannot() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    for (label, expected) in [("Gold", Some(Dragged::Material(0))), ("Teapot", None)] {
        let from = panel.get_by_label(label).rect().center();
        panel.drag_at(from);
        panel.step();
        panel.hover_at(from + vec2(30.0, 40.0));
        panel.step();
        let dragged = egui::DragAndDrop::payload::<Dragged>(&panel.ctx).map(|dragged| *dragged);
        assert_eq!(dragged, expected, "{label}");
        panel.drop_at(from + vec2(30.0, 40.0));
        panel.run();
    }
    assert!(panel.state().actions.is_empty(), "a drag is no click: {:?}", panel.state().actions);
}

#[test]
fn variants_are_chosen_where_there_are_any() {
    let without = panel(named(&["Floor"]), &[]);
    assert!(without.query_by_label("Variant").is_none());
    let mut dataset = named(&["Floor"]);
    let part = Part { object: 0, material: 0 };
    let parts = vec![PartVariants { part, plain: 0, in_variants: vec![0, 1] }];
    dataset.scene.variants = Variants { names: vec!["red".into(), "blue".into()], parts };
    let mut panel = panel(dataset, &[]);
    let shown = |panel: &Harness<Probe>| panel.get_by_role_and_label(Role::ComboBox, "Variant").value();
    assert_eq!(shown(&panel).as_deref(), Some("red"), "what the file shows first is the red one");
    panel.get_by_role_and_label(Role::ComboBox, "Variant").click();
    panel.run();
    panel.get_by_label("blue").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::ChooseVariant(Some(1))]));
    for (material, expected) in [(1, "blue"), (7, "red")] {
        panel.state_mut().document.assigned = [(part, material)].into();
        panel.run();
        assert_eq!(shown(&panel).as_deref(), Some(expected));
    }
}
