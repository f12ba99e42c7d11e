//! Objects of a changed scene file have other numbers, and keep their poses, materials and selection.

use super::{Place, Window, few_lights, kept::StopsInVisibility};
use crate::{
    actions::{Action, BakeAction, PoseAction, SelectAction},
    document::{Edit, handling::PlacedPivot},
    jobs::Imported,
    viewport::gizmo::Tool,
};
use egui::Key;
use glam::Vec3;
use lapidary_core::scene::pose::{Pose, Poses};
use lapidary_precompute::{BakeJob, Leftover, bake, resolve};

const MOVED: Pose = Pose { translate: Vec3::new(0.2, 0.1, 0.0), ..Pose::AS_BAKED };
const FLOOR: u32 = 0;
/// The number of the pyramid at first, and after a rug came before it.
const PYRAMID: u32 = 1;
const PYRAMID_NOW: u32 = 2;

/// A window with a bake, whose pyramid is moved and selected, and whose file gained a rug.
fn with_a_rug(place: &Place) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.document.bake = few_lights();
    window.perform(Action::Select(SelectAction::Object(Some(FLOOR))));
    window.perform(Action::Select(SelectAction::Toggle(PYRAMID)));
    window.perform(Action::Edit { edit: Edit::Poses([(PYRAMID, MOVED)].into()), label: "Move object" });
    let rug = "o rug\nv -0.9 0.01 0.5\nv 0.9 0.01 0.5\nv 0.9 0.01 0.9\nf 5 7 6\no pyramid";
    let shifted = super::SCENE.replace("o pyramid", rug);
    let shifted =
        [("f 5 9 6", "f 8 12 9"), ("f 6 9 7", "f 9 12 10"), ("f 7 9 8", "f 10 12 11"), ("f 8 9 5", "f 11 12 8")]
            .iter()
            .fold(shifted, |text, (before, now)| text.replace(before, now));
    std::fs::write(place.path("scene.obj"), shifted).unwrap();
    let changed = Imported::read(&place.path("scene.obj"), &Default::default()).unwrap();
    window.0.state_mut().work.scene_changed(&place.path("scene.obj"), changed);
    window.0.run_steps(2);
    assert_eq!(window.0.state().work.document.objects, ["floor", "pyramid"], "the bake before is still seen");
    window
}

#[test]
fn a_bake_moves_the_object_that_was_moved_and_undo_and_selection_follow_it() {
    let place = Place::new();
    let mut window = with_a_rug(&place);
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    window.wait("the bake", |s| s.baking.progress().is_none());
    let state = window.0.state();
    assert_eq!(state.work.document.objects, ["floor", "rug", "pyramid"]);
    let mut expected = Poses::default();
    expected.set(PYRAMID_NOW, MOVED);
    assert_eq!(state.work.scene.shown().unwrap().dataset.scene.placed_poses(), expected);
    assert_eq!(state.work.document.poses, expected);
    assert_eq!(state.work.selection.objects().collect::<Vec<_>>(), [PYRAMID_NOW, FLOOR]);
    assert_eq!(state.work.selection.part.map(|part| part.object), Some(PYRAMID_NOW));
    window.perform(Action::Undo);
    assert!(window.0.state().work.document.poses.is_empty());
    window.perform(Action::Redo);
    assert_eq!(window.0.state().work.document.poses, expected);
}

#[test]
fn what_an_interrupted_bake_left_is_known_under_the_numbers_of_the_file() {
    let place = Place::new();
    let mut window = with_a_rug(&place);
    let scene = lapidary_interchange::import::import(&place.path("scene.obj")).unwrap().scene;
    for (object, expected) in [(PYRAMID_NOW, Leftover::Fitting), (PYRAMID, Leftover::OfAnother)] {
        let mut poses = Poses::default();
        poses.set(object, MOVED);
        let job = BakeJob::new(resolve(few_lights()).unwrap(), place.path("scene.cuts"));
        let job = BakeJob { chunks: Some(4), poses, ..job };
        assert!(bake(scene.clone(), &job, &StopsInVisibility::default()).is_err());
        let state = window.0.state_mut();
        state.baking.leftover = None;
        assert_eq!(state.baking.leftover(&state.work), expected);
    }
}

fn hidden(window: &Window) -> Vec<u32> {
    window.0.state().work.document.poses.hidden().collect()
}

#[test]
fn an_object_is_isolated_and_that_ends_without_showing_what_was_hidden_before() {
    let place = Place::new();
    let mut window = with_a_rug(&place);
    window.perform(Action::Select(SelectAction::Object(Some(FLOOR))));
    window.0.key_press(Key::Slash);
    window.0.run_steps(2);
    assert_eq!(hidden(&window), [PYRAMID]);
    window.0.key_press(Key::Slash);
    window.0.run_steps(2);
    assert_eq!(hidden(&window), [0; 0]);
    window.perform(Action::Undo);
    assert_eq!(hidden(&window), [PYRAMID], "each is a step of undo");
    window.perform(Action::Pose(PoseAction::Isolate(vec![FLOOR])));
    assert_eq!(hidden(&window), [PYRAMID], "the others were hidden before");
    window.perform(Action::Pose(PoseAction::Isolate(vec![FLOOR])));
    assert_eq!(hidden(&window), [PYRAMID], "negative control: what isolation did not hide stays hidden");
}

#[test]
fn a_locked_object_has_no_handles_and_a_placed_pivot_shows_its_ring() {
    let place = Place::new();
    let mut window = with_a_rug(&place);
    window.perform(Action::Select(SelectAction::Object(Some(PYRAMID))));
    let corner = Vec3::new(0.3, 0.0, 0.3);
    let pivot = PlacedPivot { point: corner, hinge: Some(Vec3::Z) };
    window.perform(Action::Pose(PoseAction::AskForPivot));
    assert!(window.0.state().pose.placing_pivot);
    window.perform(Action::Pose(PoseAction::PlacePivot(Some(pivot))));
    let state = window.0.state();
    assert!(!state.pose.placing_pivot && state.pose.tool == Some(Tool::Turn));
    let kept = state.work.document.handling_of(PYRAMID).pivot.unwrap();
    assert!(kept.point.distance(corner - MOVED.translate) < 1e-5, "{kept:?}: with the object as in the file");
    let movable = state.pose.movable(&state.work).unwrap();
    assert!(movable.place(&state.work.document.poses).distance(corner) < 1e-5, "it moves along with the object");
    let locked = state.work.document.with_handling([PYRAMID], |own| own.locked = true);
    window.perform(Action::Edit { edit: Edit::Handling(locked), label: "Lock" });
    assert!(window.0.state().pose.movable(&window.0.state().work).is_none());
    assert!(window.shows("This object is locked"));
    window.perform(Action::Undo);
    assert!(window.0.state().pose.movable(&window.0.state().work).is_some(), "negative control");
}

#[test]
fn a_bake_asked_for_while_one_runs_starts_again_only_if_something_else_is_shown() {
    let place = Place::new();
    let mut window = with_a_rug(&place);
    let begin = || Action::Bake(BakeAction::Begin { resume: false });
    window.perform(begin());
    assert!(window.0.state().baking.progress().is_some());
    window.perform(begin());
    assert!(window.has_said("being baked already") && !window.has_said("starts again"), "negative control");
    let raised = Pose { translate: Vec3::Y, ..MOVED };
    window.perform(Action::Edit { edit: Edit::Poses([(PYRAMID, raised)].into()), label: "Move object" });
    window.perform(begin());
    assert!(window.has_said("starts again"));
    window.wait("the other bake", |s| s.baking.progress().is_none() && s.baking.again.is_none());
    let baked = window.0.state().work.scene.shown().unwrap().dataset.scene.placed_poses();
    assert_eq!(baked.of(PYRAMID_NOW), raised);
}
