//! The selected objects in a viewport without a window: results of drags of their handles.

use super::*;
use crate::{
    actions::{CameraAction, PoseAction, SelectAction},
    document::handling::PlacedPivot,
    viewport::gizmo::{Pivot, Tool},
};
use lapidary_core::{ray::Intersector, scene::pose::Pose};

/// The right square of the scene, and its center.
const OBJECT: u32 = 1;
const CENTER: Vec3 = Vec3::X;
/// The left square, whose center is the opposite.
const OTHER: u32 = 0;

/// The right square selected, with the handles of a tool, seen at an angle.
fn posing(tool: Option<Tool>) -> Harness<'static, App> {
    let mut harness = harness();
    let app = harness.state_mut();
    app.document.camera.eye = Vec3::new(2.0, 1.5, 4.0);
    (app.selected, app.tool) = (Some(OBJECT), tool);
    harness.run();
    harness
}

fn pose(harness: &Harness<App>) -> Pose {
    harness.state().document.poses.of(OBJECT)
}

/// A position at a distance in points from the center, in a direction of the world.
fn beside_center(harness: &Harness<App>, direction: Vec3, points: f32) -> Pos2 {
    let rect = harness.get_by_label("Viewport").rect();
    let projection = Projection::new(&harness.state().document.camera, rect);
    at(harness, CENTER + points * projection.metres_per_point(CENTER).unwrap() * direction)
}

/// The labels of the edits of poses.
fn labels(harness: &Harness<App>) -> Vec<&'static str> {
    let label = |action: &Action| match action {
        Action::Edit { edit: Edit::Poses(poses), label } if poses.keys().eq([&OBJECT]) => Some(*label),
        _ => None,
    };
    harness.state().log.iter().filter_map(label).collect()
}

fn drag_with(harness: &mut Harness<App>, modifiers: Modifiers, from: Pos2, to: Pos2) {
    harness.event(egui::Event::ModifiersChanged(modifiers));
    drag(harness, from, to - from);
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    harness.step();
}

#[test]
fn a_drag_of_an_arrow_moves_the_object_by_as_much_as_the_pointer_in_one_gesture() {
    for (index, axis) in Vec3::AXES.into_iter().enumerate() {
        let mut harness = posing(Some(Tool::Move));
        let grabbed = beside_center(&harness, axis, 60.0);
        let rect = harness.get_by_label("Viewport").rect();
        let scale = Projection::new(&harness.state().document.camera, rect).metres_per_point(CENTER).unwrap();
        // The same point of the arrow after a move by one meter.
        let to = at(&harness, CENTER + (60.0 * scale + 1.0) * axis);
        drag(&mut harness, grabbed, to - grabbed);
        let moved = pose(&harness).translate;
        assert!((moved[index] - 1.0).abs() < 1e-2 && (moved - moved[index] * axis).length() < 1e-5, "{axis}: {moved}");
        let labels = labels(&harness);
        assert!(labels.len() > 1 && labels.iter().all(|label| *label == "Move"), "{labels:?}");
        assert_eq!(gestures(&harness), 1);
        assert!(
            !harness
                .state()
                .log
                .iter()
                .any(|a| matches!(a, Action::Camera(CameraAction::To(_)) | Action::Select(SelectAction::Object(_))))
        );
    }
}

#[test]
fn ctrl_snaps_moves_to_steps() {
    let mut harness = posing(Some(Tool::Move));
    let (from, to) = (beside_center(&harness, Vec3::Y, 60.0), beside_center(&harness, Vec3::Y, 123.0));
    drag_with(&mut harness, Modifiers::COMMAND, from, to);
    let steps = 10.0 * pose(&harness).translate.y;
    assert!(steps > 0.5 && (steps - steps.round()).abs() < 1e-4, "{steps}");
    let mut harness = posing(Some(Tool::Move));
    drag(&mut harness, from, to - from);
    let steps = 10.0 * pose(&harness).translate.y;
    assert!((steps - steps.round()).abs() > 1e-2, "negative control: {steps}");
}

#[test]
fn a_quarter_of_a_ring_turns_the_object_by_ninety_degrees() {
    let mut harness = posing(Some(Tool::Turn));
    // Both lie on the ring about Y alone.
    let [from, to] = [Vec3::X + Vec3::Z, Vec3::X - Vec3::Z].map(|d| beside_center(&harness, d.normalize(), 84.0));
    drag_with(&mut harness, Modifiers::COMMAND, from, to);
    let turned = pose(&harness).rotation();
    assert!((turned * Vec3::Z).distance(Vec3::X) < 1e-3, "{:?}", pose(&harness));
    assert_eq!((labels(&harness)[0], gestures(&harness)), ("Turn", 1));
    // Another turn adds to the first.
    drag_with(&mut harness, Modifiers::COMMAND, from, to);
    assert!((pose(&harness).rotation() * Vec3::Z).distance(Vec3::NEG_Z) < 1e-3, "{:?}", pose(&harness));
}

#[test]
fn the_square_scales_the_object() {
    let mut harness = posing(Some(Tool::Scale));
    let center = at(&harness, CENTER);
    let out = vec2(59.0, -59.0);
    drag(&mut harness, center + out, 0.5 * out);
    assert!((pose(&harness).scale - 1.5).abs() < 1e-2, "{:?}", pose(&harness));
    assert_eq!((labels(&harness)[0], gestures(&harness)), ("Scale", 1));
    drag(&mut harness, center + out, -3.0 * out);
    assert!(pose(&harness).validate("").is_ok(), "{:?}", pose(&harness));
}

#[test]
fn escape_puts_the_object_back() {
    let mut harness = posing(Some(Tool::Move));
    let from = beside_center(&harness, Vec3::Y, 60.0);
    press(&mut harness, from);
    harness.hover_at(from + vec2(0.0, -40.0));
    harness.step();
    assert!(pose(&harness) != Pose::AS_BAKED && harness.state().last.unwrap().moving, "negative control");
    harness.key_press(Key::Escape);
    harness.step();
    release(&mut harness, from + vec2(0.0, -60.0));
    assert_eq!((pose(&harness), gestures(&harness)), (Pose::AS_BAKED, 1));
}

#[test]
fn clicks_on_the_middle_select_and_drags_beside_handles_orbit() {
    let mut harness = posing(Some(Tool::Move));
    let camera = harness.state().document.camera.clone();
    let middle = at(&harness, CENTER);
    click(&mut harness, middle);
    assert!(
        matches!(harness.state().log[0], Action::Select(SelectAction::Object(Some(OBJECT)))),
        "{:?}",
        harness.state().log
    );
    let arrow = beside_center(&harness, Vec3::Y, 60.0);
    harness.state_mut().log.clear();
    click(&mut harness, arrow);
    assert!(harness.state().log.is_empty(), "an arrow that is clicked does nothing");
    assert_eq!((pose(&harness), &harness.state().document.camera), (Pose::AS_BAKED, &camera));
    let beside = at(&harness, Vec3::new(-1.0, 0.0, 0.0));
    drag(&mut harness, beside, vec2(40.0, 0.0));
    assert!(pose(&harness) == Pose::AS_BAKED && harness.state().document.camera != camera);
}

#[test]
fn without_a_tool_drags_orbit_from_everywhere() {
    let mut harness = posing(None);
    let from = beside_center(&harness, Vec3::Y, 60.0);
    drag(&mut harness, from, vec2(0.0, -40.0));
    assert_eq!(pose(&harness), Pose::AS_BAKED);
    assert!(harness.state().log.iter().any(|action| matches!(action, Action::Camera(CameraAction::To(_)))));
}

/// The right square active and the left one with it, with the handles of a tool.
fn posing_both(tool: Tool, pivot: Pivot) -> Harness<'static, App> {
    let mut harness = posing(Some(tool));
    let app = harness.state_mut();
    (app.others, app.pivot) = (vec![OTHER], pivot);
    harness.run();
    harness
}

/// Centers of both squares: the active one, and the other.
fn centers(harness: &Harness<App>) -> [Vec3; 2] {
    [(OBJECT, CENTER), (OTHER, -CENTER)]
        .map(|(object, center)| center + harness.state().document.poses.of(object).translate)
}

#[test]
fn a_drag_of_an_arrow_moves_all_by_the_same_and_escape_puts_all_back() {
    let mut harness = posing_both(Tool::Move, Pivot::Active);
    let from = beside_center(&harness, Vec3::Y, 60.0);
    press(&mut harness, from);
    harness.hover_at(from + vec2(0.0, -40.0));
    harness.step();
    let [active, other] = centers(&harness);
    assert!(active.y > 0.1 && active.distance(other + 2.0 * CENTER) < 1e-6, "{active} {other}");
    harness.key_press(Key::Escape);
    harness.step();
    release(&mut harness, from);
    assert!(harness.state().document.poses.is_empty() && gestures(&harness) == 1);
}

#[test]
fn a_quarter_turn_takes_the_other_around_the_active_object_or_each_around_itself() {
    for (pivot, expected) in [(Pivot::Active, [CENTER, CENTER + 2.0 * Vec3::Z]), (Pivot::Own, [CENTER, -CENTER])] {
        let mut harness = posing_both(Tool::Turn, pivot);
        let [from, to] = [Vec3::X + Vec3::Z, Vec3::X - Vec3::Z].map(|d| beside_center(&harness, d.normalize(), 84.0));
        drag_with(&mut harness, Modifiers::COMMAND, from, to);
        let centers = centers(&harness);
        let off = centers.iter().zip(expected).map(|(center, expected)| center.distance(expected));
        assert!(off.fold(0.0, f32::max) < 1e-3, "{pivot:?}: {centers:?}");
        for object in [OBJECT, OTHER] {
            let turned = harness.state().document.poses.of(object).rotation();
            assert!((turned * Vec3::Z).distance(Vec3::X) < 1e-3, "{pivot:?}: {turned:?}");
        }
        assert_eq!(gestures(&harness), 1);
    }
}

#[test]
fn handles_lie_at_the_pivot_and_scale_both_away_from_it() {
    let mut harness = posing_both(Tool::Scale, Pivot::Selection);
    let out = vec2(59.0, -59.0);
    let [middle, active] = [Vec3::ZERO, CENTER].map(|place| at(&harness, place));
    drag(&mut harness, active + out, 0.5 * out);
    assert!(harness.state().document.poses.is_empty(), "negative control: no handle lies there");
    let camera = harness.state().document.camera.clone();
    harness.state_mut().document.camera = Camera { eye: Vec3::new(2.0, 1.5, 4.0), ..camera };
    harness.run();
    drag(&mut harness, middle + out, 0.5 * out);
    assert!((pose(&harness).scale - 1.5).abs() < 1e-2, "{:?}", pose(&harness));
    let [active, other] = centers(&harness);
    assert!(
        active.distance(pose(&harness).scale * CENTER) < 1e-5 && active.distance(-other) < 1e-5,
        "{active} {other}"
    );
}

/// The pivot placed by a click, in the world.
fn placed(harness: &mut Harness<App>, place: Vec3) -> Option<PlacedPivot> {
    harness.state_mut().log.clear();
    let at = at(harness, place);
    click(harness, at);
    let placed = |action: &Action| match action {
        Action::Pose(PoseAction::PlacePivot(pivot)) => Some(*pivot),
        _ => None,
    };
    harness.state().log.iter().find_map(placed).expect("the click places a pivot or gives it up")
}

#[test]
fn a_click_on_an_edge_places_a_hinge_and_elsewhere_a_point() {
    let mut harness = posing(None);
    harness.state_mut().click_for = Some(ClickFor::Pivot);
    harness.run();
    let on_edge = placed(&mut harness, Vec3::new(0.5, 0.2, 0.0)).unwrap();
    assert!(on_edge.hinge.unwrap().dot(Vec3::Y).abs() > 0.999, "{on_edge:?}");
    assert!(on_edge.point.distance(Vec3::new(0.5, 0.2, 0.0)) < 0.02, "{on_edge:?}");
    let upper = placed(&mut harness, Vec3::new(1.2, 0.5, 0.0)).unwrap();
    assert!(upper.hinge.unwrap().dot(Vec3::X).abs() > 0.999, "{upper:?}");
    let inside = placed(&mut harness, CENTER).unwrap();
    assert_eq!(inside.hinge, None, "the diagonal of a flat square is no edge");
    assert!(inside.point.distance(CENTER) < 0.02, "{inside:?}");
    harness.key_press(Key::Escape);
    harness.run();
    assert!(matches!(harness.state().log.last(), Some(Action::Pose(PoseAction::PlacePivot(None)))));
}

#[test]
fn an_edge_behind_the_surface_under_the_pointer_is_not_taken() {
    let mut harness = posing(None);
    let app = harness.state_mut();
    app.click_for = Some(ClickFor::Pivot);
    // The other square goes behind this one, with an edge across its middle.
    app.document.camera.eye = Vec3::new(1.0, 0.0, 5.0);
    app.document.camera.target = CENTER;
    for corner in 0..4 {
        app.mesh.positions[corner] += Vec3::new(2.4, 0.0, -2.0);
    }
    app.intersector = Intersector::new(&app.mesh);
    harness.run();
    let hidden = app_edge(&harness);
    let behind = placed(&mut harness, hidden).unwrap();
    assert_eq!(behind.hinge, None, "{behind:?}");
    for corner in 0..4 {
        harness.state_mut().mesh.positions[corner].z += 4.0;
    }
    let mesh = harness.state().mesh.clone();
    harness.state_mut().intersector = Intersector::new(&mesh);
    harness.run();
    let seen = app_edge(&harness);
    assert!(placed(&mut harness, seen).unwrap().hinge.is_some(), "negative control: before it");
}

/// The middle of the left edge of the other square.
fn app_edge(harness: &Harness<App>) -> Vec3 {
    let positions = &harness.state().mesh.positions;
    0.5 * (positions[0] + positions[3])
}
