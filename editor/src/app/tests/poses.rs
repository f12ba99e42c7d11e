//! Objects are posed in the window: the picture follows at once, and undo and sessions know it.

use super::{Place, Window, few_lights};
use crate::{
    actions::{Action, BakeAction, CameraAction, FileAction, PoseAction, SelectAction},
    app::state::EditorState,
    bake::stale_now,
    document::Edit,
};
use egui::{Key, Modifiers};
use glam::Vec3;
use lapidary_core::{
    animation::ClipTime,
    dataset::{BakeParts, BakeSettings, Dataset, ObjectBasesSettings},
    scene::pose::Pose,
};
use lapidary_interchange::{image, import::import};
use lapidary_precompute::{BakeJob, Silent, bake, resolve};
use lapidary_render::{Solution, Tier};
use std::{cell::Cell, path::Path};

const PYRAMID: u32 = 1;

fn wait_for_picture(window: &mut Window) {
    window.wait("the whole picture", |s| s.picture.shown().is_some_and(|p| p.samples == p.of_samples));
}

/// A window with the small scene, whose whole picture is shown.
fn opened() -> (Place, Window) {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    wait_for_picture(&mut window);
    (place, window)
}

fn pixels(state: &EditorState) -> Vec<[u8; 4]> {
    state.picture.shown().map(|shown| shown.pixels.to_vec()).unwrap_or_default()
}

fn pose(window: &mut Window, pose: Pose) {
    window.perform(Action::Edit { edit: Edit::Poses([(PYRAMID, pose)].into()), label: "Move" });
    window.perform(Action::EndGesture);
}

#[test]
fn a_posed_object_is_seen_elsewhere_at_once_and_undo_brings_back_the_baked_picture() {
    let (place, mut window) = opened();
    let as_baked = pixels(window.0.state());
    let words = "Preview: implicit visibility";
    assert!(!window.shows(words));
    let moved =
        Pose { translate: Vec3::new(0.4, 0.3, 0.0), rotate_degrees: Vec3::Y * 30.0, scale: 0.7, ..Pose::AS_BAKED };
    pose(&mut window, moved);
    assert!(window.shows(words));
    window.wait("another picture", |s| pixels(s) != as_baked);
    wait_for_picture(&mut window);
    let posed = pixels(window.0.state());

    let session = place.path("posed.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    let mut again = place.window();
    again.open(&session);
    wait_for_picture(&mut again);
    assert_eq!(again.0.state().work.document.poses.of(PYRAMID), moved);
    assert!(again.shows(words));
    again.wait("the posed picture", |s| pixels(s) == posed);

    window.perform(Action::Undo);
    window.wait("the picture as baked", |s| pixels(s) == as_baked);
    assert!(!window.shows(words));
    window.perform(Action::Redo);
    window.wait("the posed picture", |s| pixels(s) == posed);
}

#[test]
fn the_picture_as_baked_goes_over_into_that_of_a_posed_object() {
    let (_place, mut window) = opened();
    let (ctx, as_baked) = (window.0.ctx.clone(), window.0.state().picture.texture().unwrap().id());
    assert!(window.0.state().picture.faded(&ctx).is_none(), "negative control: nothing was before it");
    pose(&mut window, Pose { translate: Vec3::new(0.4, 0.3, 0.0), ..Pose::AS_BAKED });
    let of = |s: &EditorState, tier| s.picture.shown().is_some_and(|shown| shown.tier == tier);
    // Each frame advances the window's time by more than a fade.
    let faded = Cell::new(None);
    window.wait("the preview", |s| {
        faded.set(s.picture.faded(&ctx));
        of(s, Tier::Implicit)
    });
    let before = faded.get().unwrap();
    assert_eq!((before.texture, before.opacity), (as_baked, 1.0));
    assert_ne!(window.0.state().picture.texture().unwrap().id(), as_baked);
    wait_for_picture(&mut window);
    window.0.run_steps(2);
    assert!(window.0.state().picture.faded(&ctx).is_none(), "it is gone");
}

#[test]
fn an_object_is_selected_and_framed_where_it_is() {
    let (_place, mut window) = opened();
    window.perform(Action::Select(SelectAction::Object(Some(PYRAMID))));
    let target = |window: &mut Window| {
        window.perform(Action::Camera(CameraAction::FrameSelection));
        window.0.state().work.document.camera.target
    };
    let before = target(&mut window);
    pose(&mut window, Pose { translate: Vec3::new(3.0, 0.0, 0.0), ..Pose::AS_BAKED });
    let after = target(&mut window);
    assert!((after - before - Vec3::X * 3.0).length() < 1e-3, "{before} {after}");
}

#[test]
fn a_posed_scene_is_baked_where_it_is_and_the_preview_gives_way() {
    let (place, mut window) = opened();
    window.0.state_mut().work.document.bake = few_lights();
    let (words, moved) = ("Preview: implicit visibility", Pose { translate: Vec3::X * 0.4, ..Pose::AS_BAKED });
    pose(&mut window, moved);
    assert!(window.shows(words));
    window.wait("the preview", |s| s.picture.shown().is_some_and(|p| p.tier == Tier::Implicit));
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    window.wait("the bake", |s| s.baking.progress().is_none());
    let baked = Dataset::read(&place.path("scene.cuts"), image::decode).unwrap();
    assert_eq!(baked.scene.placed_poses().of(PYRAMID), moved);
    window.wait("the picture by cuts", |s| s.picture.shown().is_some_and(|p| p.tier == Tier::Cuts));
    assert!(!window.shows(words) && stale_now(&window.0.state().work).is_empty());
    window.perform(Action::Undo);
    assert!(window.shows(words), "back by a preview: the bake is of another place");
    assert!(stale_now(&window.0.state().work).iter().any(|reason| reason.contains("moved")));

    let mut alone = place.window();
    alone.open(&place.path("scene.cuts"));
    wait_for_picture(&mut alone);
    assert_eq!(alone.0.state().work.document.poses.of(PYRAMID), moved);
    assert!(!alone.shows(words), "as it was baked");
}

#[test]
fn after_a_move_cuts_are_baked_anew_by_themselves_and_after_its_undo_again() {
    let (place, mut window) = opened();
    let file = || std::fs::read(place.path("scene.cuts")).unwrap();
    let before = file();
    let cuts = |s: &EditorState| s.work.scene.baked.as_ref().unwrap().dataset.cuts.clone();
    let as_baked = cuts(window.0.state());
    window.0.state_mut().work.document.bake = few_lights();
    let moved = Pose { translate: Vec3::X * 0.4, ..Pose::AS_BAKED };
    pose(&mut window, moved);
    window.wait("the preview", |s| s.picture.shown().is_some_and(|p| p.tier == Tier::Implicit));
    assert!(window.0.state().baking.run.is_none(), "negative control: nobody asked for it");
    window.0.state_mut().work.preferences.follows_edits = true;
    let placed = |s: &EditorState| s.work.scene.baked.as_ref().unwrap().dataset.scene.placed_poses().of(PYRAMID);
    let is_by_cuts = |s: &EditorState| s.picture.shown().is_some_and(|p| p.tier == Tier::Cuts);
    window.wait("the picture by cuts", |s| placed(s) == moved && is_by_cuts(s));
    assert!(stale_now(&window.0.state().work).is_empty() && file() == before, "nothing is written");
    assert!(!cuts(window.0.state()).has_same_stored(&as_baked), "negative control");
    window.perform(Action::Undo);
    window.wait("the way back", |s| placed(s) == Pose::AS_BAKED && s.baking.run.is_none() && is_by_cuts(s));
    assert!(cuts(window.0.state()).has_same_stored(&as_baked), "the bake of before");
}

#[test]
fn an_object_is_hidden_by_its_eye_or_a_key_and_cuts_are_baked_anew_without_it() {
    let (place, mut window) = opened();
    let as_baked = pixels(window.0.state());
    let is_hidden = |window: &Window| window.0.state().work.document.poses.of(PYRAMID).hidden;
    window.click("Hide pyramid");
    window.wait("the preview", |s| s.picture.shown().is_some_and(|p| p.tier == Tier::Implicit));
    assert!(is_hidden(&window) && window.undo_name().as_deref() == Some("Hide pyramid"));
    wait_for_picture(&mut window);
    assert!(pixels(window.0.state()) != as_baked, "it is gone");

    let session = place.path("hidden.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    let mut again = place.window();
    again.open(&session);
    wait_for_picture(&mut again);
    assert!(is_hidden(&again));

    window.click("Show pyramid");
    window.wait("the picture as baked", |s| pixels(s) == as_baked);
    window.perform(Action::Select(SelectAction::Object(Some(PYRAMID))));
    window.0.state_mut().work.document.bake = few_lights();
    window.0.state_mut().work.preferences.follows_edits = true;
    window.0.key_press(Key::H);
    let placed = |s: &EditorState| s.work.scene.baked.as_ref().unwrap().dataset.scene.placed_poses().of(PYRAMID);
    let is_by_cuts = |s: &EditorState| s.picture.shown().is_some_and(|p| p.tier == Tier::Cuts);
    window.wait("the picture by cuts", |s| placed(s).hidden && is_by_cuts(s));
    assert!(
        stale_now(&window.0.state().work).is_empty() && window.0.state().pose.movable(&window.0.state().work).is_none()
    );
    window.0.key_press_modifiers(Modifiers::SHIFT, Key::H);
    window.wait("the way back", |s| !placed(s).hidden && s.baking.run.is_none() && pixels(s) == as_baked);
    assert!(!is_hidden(&window));
}

#[test]
fn bounces_solved_anew_have_words_of_their_own_and_a_pose_taken_back_begins_as_before() {
    let place = Place::new();
    let functions = ObjectBasesSettings { functions: 400, levels: 3, sender_level: 1 };
    let mode = BakeParts::ENVIRONMENT.with(BakeParts::RADIOSITY);
    let settings = BakeSettings { mode, object_bases: functions, ..few_lights() };
    let job = BakeJob::new(resolve(settings).unwrap(), place.path("scene.cuts"));
    bake(import(&place.path("scene.obj")).unwrap().scene, &job, &Silent).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.cuts"));
    window.0.state_mut().work.document.solution = Solution::Radiosity;
    wait_for_picture(&mut window);
    let as_baked = pixels(window.0.state());
    let (preview, solved) = ("Preview: implicit visibility", "Bounced light is solved for the moved objects");
    let tier = |s: &EditorState| s.picture.shown().map(|shown| shown.tier);
    pose(&mut window, Pose { translate: Vec3::X * 0.4, ..Pose::AS_BAKED });
    assert!(!window.shows(solved), "the picture is still that of before");
    window.wait("the solved light", |s| tier(s) == Some(Tier::Solved));
    window.0.run_steps(1);
    assert!(window.shows(solved) && !window.shows(preview));
    window.perform(Action::Undo);
    window.wait("the picture as baked", |s| tier(s) == Some(Tier::Cuts) && pixels(s) == as_baked);
    assert!(!window.shows(solved));
}

#[test]
fn a_dataset_alone_has_the_timeline_of_the_scene_file_beside_it() {
    let place = Place::new();
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/bending-tower");
    let file = bundled.join("bending-tower.gltf");
    let bake = |name: &str| {
        let job = BakeJob::new(resolve(few_lights()).unwrap(), place.path(name));
        bake(import(&file).unwrap().scene, &job, &Silent).unwrap();
    };
    bake("bending-tower.cuts");
    place.bake();
    let opened = |name: &str| {
        let mut window = place.window();
        window.open(&place.path(name));
        window
    };
    let alone = opened("bending-tower.cuts");
    assert!(
        !alone.shows("Play") && alone.0.state().work.scene.animation.is_none(),
        "negative control: no file is there"
    );
    for name in ["bending-tower.gltf", "bending-tower.bin"] {
        std::fs::copy(bundled.join(name), place.path(name)).unwrap();
    }
    std::fs::copy(place.path("bending-tower.gltf"), place.path("scene.gltf")).unwrap();
    let other = opened("scene.cuts");
    let scene = &other.0.state().work.scene;
    assert!(scene.animation.is_none() && scene.shown().is_some(), "the file beside it is of another scene");
    let mut alone = opened("bending-tower.cuts");
    assert!(alone.shows("Play"));
    alone.perform(Action::Pose(PoseAction::ClipTime(Some(ClipTime { clip: "Block".into(), seconds: 0.5 }))));
    assert!(alone.shows("Preview: implicit visibility"));
}
