use super::*;
use crate::{
    actions::{Action, CameraAction, FileAction, MaterialAction, SelectAction},
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
    scenes: Vec<String>,
    dataset: Dataset,
    panel: ScenePanel,
    pivot: Pivot,
    selected: Option<u32>,
    others: Vec<u32>,
    /// A point and a direction of the first object's hinge.
    hinge: Option<(Vec3, Vec3)>,
    actions: Vec<Action>,
}

/// Centers of objects: along X, as many meters apart as their numbers.
fn center(object: u32) -> Vec3 {
    object as f32 * Vec3::X
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
        let Probe { document, scenes, dataset, panel, pivot, selected, others, hinge, actions } = probe;
        let (selected_object, dataset) = (*selected, Some(&*dataset));
        let is_there = |object: &u32| (*object as usize) < document.objects.len();
        let selected = [0].into_iter().chain(others.iter().copied()).filter(is_there);
        let posable: Vec<Subject> = selected
            .map(|object| {
                let (middle, hinge) = hinge.map_or((center(object), None), |(point, axis)| (point, Some(axis)));
                Subject { object, center: center(object), middle, hinge }
            })
            .collect();
        let context = SceneContext {
            document,
            scenes: (scenes, Some("Day")),
            dataset,
            selected_object,
            other_objects: others,
            placing_pivot: false,
            posable: &posable,
            selected_material: None,
        };
        show(ui, (panel, pivot), &context, actions);
    };
    let (panel, pivot) = (ScenePanel::default(), Pivot::default());
    let scenes = ["Day", "Night"].map(String::from).into();
    let probe = Probe {
        document,
        scenes,
        dataset,
        panel,
        pivot,
        selected: Some(0),
        others: Vec::new(),
        hinge: None,
        actions: Vec::new(),
    };
    // Steps short enough that two clicks are a double click.
    let builder = Harness::builder().with_size(vec2(WIDTH, 700.0)).with_step_dt(0.02).with_max_steps(60);
    let mut panel = builder.build_ui_state(show, probe);
    panel.run();
    assert!(panel.state().actions.is_empty(), "showing asks for nothing");
    assert_fits(&panel, WIDTH);
    panel
}

/// The bookmarks' names in the last request.
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
    let moved = Pose { translate: Vec3::Y * 1.5, ..Pose::AS_BAKED };
    assert_eq!(typed(&mut panel, "Move Y", "1.5"), [(0, moved)]);
    let turned = Pose { rotate_degrees: Vec3::Z * 90.0, ..Pose::AS_BAKED };
    assert_eq!(typed(&mut panel, "Turn Z", "90"), [(0, turned)]);
    assert_eq!(typed(&mut panel, "Scale value", "0.002"), [(0, Pose { scale: 0.002, ..Pose::AS_BAKED })]);
    panel.state_mut().document.poses.set(0, moved);
    panel.state_mut().actions.clear();
    panel.run();
    assert_eq!(reset(&mut panel), [(0, Pose::AS_BAKED)]);
}

/// The poses requested by typing a number.
fn typed(panel: &mut Harness<Probe>, entry: &str, text: &str) -> Vec<(u32, Pose)> {
    panel.state_mut().actions.clear();
    panel.get_by_label(entry).click();
    panel.run();
    panel.key_press_modifiers(Modifiers::COMMAND, Key::A);
    panel.get_by_label(entry).type_text(text);
    panel.key_press(Key::Enter);
    panel.run();
    let [edit, Action::EndGesture] = &panel.state().actions[..] else { panic!("{:?}", panel.state().actions) };
    poses_asked(edit).expect("poses")
}

fn poses_asked(action: &Action) -> Option<Vec<(u32, Pose)>> {
    let Action::Edit { edit: Edit::Poses(poses), .. } = action else { return None };
    Some(poses.iter().map(|(&object, &pose)| (object, pose)).collect())
}

/// The active floor and the lid, which is 2 m along X.
fn two_selected() -> Harness<'static, Probe> {
    let mut panel = panel(named(&["Floor", "Pot", "Lid"]), &[]);
    panel.state_mut().document.objects = ["Floor", "Pot", "Lid"].map(String::from).to_vec();
    panel.state_mut().others = vec![2];
    panel.run();
    panel
}

#[test]
fn numbers_move_turn_and_scale_all_selected_objects_about_the_pivot() {
    let mut panel = two_selected();
    let lid = Pose { translate: Vec3::NEG_Y, rotate_degrees: Vec3::Z * 30.0, scale: 3.0, ..Pose::AS_BAKED };
    panel.state_mut().document.poses.set(2, lid);
    let floor = Pose { translate: Vec3::Z * 0.5, ..Pose::AS_BAKED };
    let moved = Pose { translate: lid.translate + floor.translate, ..lid };
    assert_eq!(typed(&mut panel, "Move Z", "0.5"), [(0, floor), (2, moved)]);
    for (pivot, floor, lid) in [
        // About the floor's center X becomes Y, and -Y becomes X.
        (Pivot::Active, Vec3::ZERO, Vec3::new(1.0, 2.0, 0.0)),
        // The middle is (1, -0.5).
        (Pivot::Selection, Vec3::new(0.5, -1.5, 0.0), Vec3::new(1.5, 0.5, 0.0)),
        (Pivot::Own, Vec3::ZERO, center(2) + lid.translate),
    ] {
        panel.state_mut().pivot = pivot;
        let turned = typed(&mut panel, "Turn Z", "90");
        let places = turned.iter().map(|(object, pose)| center(*object) + pose.translate);
        let off = places.zip([floor, lid]).map(|(place, expected)| place.distance(expected));
        assert!(off.fold(0.0, f32::max) < 1e-5, "{pivot:?}: {turned:?}");
        let degrees = [0, 1].map(|i| turned[i].1.rotate_degrees);
        assert!(degrees[0] == Vec3::Z * 90.0 && degrees[1].distance(Vec3::Z * 120.0) < 1e-3, "{pivot:?}: {degrees:?}");
    }
    let scaled = typed(&mut panel, "Scale value", "0.5");
    assert_eq!(scaled.iter().map(|(_, pose)| pose.scale).collect::<Vec<_>>(), [0.5, 1.5]);
    let limited = typed(&mut panel, "Scale value", "10000");
    assert!((limited[0].1.scale * 3.0 / 1e4 - 1.0).abs() < 1e-5, "the lid is at the limit: {limited:?}");
}

#[test]
fn a_drag_of_a_number_is_one_gesture_of_all() {
    let mut panel = two_selected();
    let from = panel.get_by_label("Turn Z").rect().center();
    panel.drag_at(from);
    panel.step();
    for i in 1..60 {
        panel.hover_at(from + vec2(2.0 * i as f32, 0.0));
        panel.step();
        let actions = std::mem::take(&mut panel.state_mut().actions);
        for (object, pose) in actions.iter().filter_map(poses_asked).flatten() {
            panel.state_mut().document.poses.set(object, pose);
        }
    }
    panel.drop_at(from + vec2(118.0, 0.0));
    panel.run();
    let [floor, lid] = [0, 2].map(|object| panel.state().document.poses.of(object));
    assert!(floor.translate == Vec3::ZERO && floor.rotate_degrees.z.abs() > 20.0, "{floor:?}");
    assert!((center(2) + lid.translate).distance(floor.rotation() * center(2)) < 1e-5, "{lid:?}");
    assert!(lid.rotation().angle_between(floor.rotation()) < 1e-3, "{lid:?}");
    assert!(matches!(panel.state().actions[..], [Action::EndGesture]), "{:?}", panel.state().actions);
}

/// The poses requested by a click on *Reset pose*.
fn reset(panel: &mut Harness<Probe>) -> Vec<(u32, Pose)> {
    panel.get_by_label("Reset pose").click();
    panel.run();
    let [edit, Action::EndGesture] = &panel.state().actions[..] else { panic!("{:?}", panel.state().actions) };
    poses_asked(edit).expect("poses")
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
    assert_eq!(panel.state().pivot, Pivot::Active);
    panel.get_by_role_and_label(Role::ComboBox, "Pivot").click();
    panel.run();
    panel.get_by_label("Own pivots").click();
    panel.run();
    assert_eq!(panel.state().pivot, Pivot::Own);
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
    assert!(
        matches!(panel.state().actions[..], [Action::Select(SelectAction::Toggle(1))]),
        "{:?}",
        panel.state().actions
    );
}

#[test]
fn clicks_select_objects_and_materials() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    panel.get_by_label("Teapot").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::Select(SelectAction::Object(Some(1)))]));
    panel.state_mut().actions.clear();
    panel.get_by_label("Gold").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::Select(SelectAction::Material(Some(0)))]));
    panel.state_mut().actions.clear();
    panel.get_by_label("Material 2").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::Select(SelectAction::Material(Some(1)))]));
}

#[test]
fn an_object_shows_its_materials_only() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    assert!(panel.query_by_label("Gold of Teapot").is_none(), "the only triangle belongs to the floor");
    panel.get_by_label("Gold of Floor").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::Select(SelectAction::Material(Some(0)))]));
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
    let labeled = |text: &str| panel.query_all_by_label_contains(text).count();
    let (eyes, all) = (labeled("Hide Object number"), labeled("Object number"));
    assert_eq!((all - eyes, eyes), (11, 10), "the list scrolls");
}

#[test]
fn the_list_scrolls_to_what_was_clicked_elsewhere_and_stays_for_a_row_in_sight() {
    assert_eq!([offset_with(3, 0.0), offset_with(12, 8.0)], [0.0, 8.0], "in sight");
    let below = offset_with(400, 0.0);
    assert!((below..below + VISIBLE_ROWS - 1.0).contains(&400.0), "{below}");
    assert_eq!(offset_with(2, 300.0), 0.0, "no row is above the first");
    let names: Vec<String> = (0..5000).map(|i| format!("Object number {i}")).collect();
    let mut panel = panel(named(&names.iter().map(String::as_str).collect::<Vec<_>>()), &[]);
    assert!(panel.query_by_label("Object number 4321").is_none(), "negative control");
    panel.state_mut().selected = Some(4321);
    panel.run();
    assert!(panel.query_by_label("Object number 4321").is_some());
    panel.state_mut().panel.filter = "number".into();
    panel.state_mut().panel.forget_document();
    assert!(panel.state().panel.filter.is_empty());
}

#[test]
fn the_menu_of_an_object_locks_it_and_a_lock_is_opened_in_its_row() {
    let mut panel = panel(named(&["Floor", "Teapot"]), &[]);
    panel.state_mut().document.objects = vec!["Floor".into(), "Teapot".into()];
    panel.run();
    panel.get_by_label("Floor").click_secondary();
    panel.run();
    panel.get_by_label("Lock").click();
    panel.run();
    let asked = panel.state().actions.clone();
    let [Action::Edit { edit, label: "Lock" }, Action::EndGesture] = &asked[..] else { panic!("{asked:?}") };
    edit.clone().swap(&mut panel.state_mut().document);
    panel.state_mut().actions.clear();
    panel.run();
    assert!(panel.state().document.handling_of(0).locked && !panel.state().document.handling_of(1).locked);
    panel.get_by_label("Unlock Floor").click();
    panel.run();
    let asked = panel.state().actions.clone();
    let [Action::Edit { edit, label: "Unlock" }, Action::EndGesture] = &asked[..] else { panic!("{asked:?}") };
    edit.clone().swap(&mut panel.state_mut().document);
    assert!(panel.state().document.handling.is_empty());
}

#[test]
fn the_angle_about_a_hinge_is_typed_and_the_hinge_stays() {
    let mut panel = panel(named(&["Chest", "Lid"]), &[]);
    panel.state_mut().document.objects = vec!["Chest".into(), "Lid".into()];
    assert!(panel.query_by_label("Hinge value").is_none(), "negative control");
    let (point, hinge) = (Vec3::new(0.0, 0.5, -0.5), Vec3::X);
    panel.state_mut().hinge = Some((point, hinge));
    panel.run();
    let [(0, pose)] = typed(&mut panel, "Hinge value", "90")[..] else { panic!() };
    assert!((pose.degrees_about(hinge) - 90.0).abs() < 1e-3, "{pose:?}");
    let place = |pose: Pose, of: Vec3| pose.world_from_baked(center(0)).transform_point3(of);
    assert!(place(pose, point).distance(point) < 1e-5 && place(pose, point + hinge).distance(point + hinge) < 1e-5);
    assert!(place(pose, center(0)).distance(center(0)) > 0.5, "negative control: the center moves");
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
    assert!(matches!(&panel.state().actions[..], [Action::Camera(CameraAction::To(c))] if c.name == "Close"));
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
    assert!(matches!(&panel.state().actions[..], [Action::Camera(CameraAction::To(c))] if c.name == "Hero"));
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
    assert!(matches!(panel.state().actions[..], [Action::Material(MaterialAction::ChooseVariant(Some(1)))]));
    for (material, expected) in [(1, "blue"), (7, "red")] {
        panel.state_mut().document.assigned = [(part, material)].into();
        panel.run();
        assert_eq!(shown(&panel).as_deref(), Some(expected));
    }
}

#[test]
fn scenes_of_the_file_are_opened_where_there_are_several() {
    let mut panel = panel(named(&["Floor"]), &[]);
    let chooser = |panel: &Harness<Probe>| panel.query_by_role_and_label(Role::ComboBox, "Scene").map(|c| c.value());
    assert_eq!(chooser(&panel), Some(Some("Day".into())));
    panel.get_by_role_and_label(Role::ComboBox, "Scene").click();
    panel.run();
    panel.get_by_label("Night").click();
    panel.run();
    let opened = |panel: &Harness<Probe>| match panel.state().actions.last() {
        Some(Action::File(FileAction::OpenSceneIn(name))) => name.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(opened(&panel).as_deref(), Some("Night"));
    panel.state_mut().document.scene_in_file = Some("Night".into());
    panel.run();
    assert_eq!(chooser(&panel), Some(Some("Night".into())));
    panel.get_by_role_and_label(Role::ComboBox, "Scene").click();
    panel.run();
    panel.get_by_label("Day").click();
    panel.run();
    assert_eq!(opened(&panel), None, "the default needs no name");
    panel.state_mut().scenes.clear();
    panel.run();
    assert_eq!(chooser(&panel), None);
}
