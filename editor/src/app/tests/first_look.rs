//! A scene that opens is seen at once and baked automatically, and its bakes are kept.

use super::{Place, few_lights};
use crate::{
    actions::{Action, BakeAction},
    document::Edit,
    jobs::{Imported, kept_bakes::draft_of},
    workspace::BakeStage,
};
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeParts, BakeSettings, Dataset},
    scene::pose::Pose,
};
use lapidary_interchange::image;

/// Opens the scene and bakes it automatically, with few lights.
fn baked_by_itself(place: &Place) -> super::Window {
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.document.bake = few_lights();
    window.bake_by_itself(true);
    window.wait("the bake", |s| s.work.scene.shown().is_some() && s.baking.progress().is_none());
    window
}

#[test]
fn a_scene_without_a_bake_is_seen_without_shadows() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    assert!(window.shows("No shadows yet") && window.shows("is not baked yet"));
    let state = window.0.state();
    assert_eq!(state.work.scene.seen(), BakeStage::Unshadowed);
    let baked = state.work.scene.rendered().unwrap();
    assert_eq!(
        baked.dataset.scene.mesh.positions.len(),
        state.work.scene.source.as_ref().unwrap().scene.mesh.positions.len()
    );
    let picture = state.picture.shown().unwrap();
    assert!(picture.lighting.nodes.radiance[1].max_element() > 0.0, "it is lit");
}

#[test]
fn a_preview_is_lit_as_its_bake_will_be() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    for (mode, is_lit) in [(BakeParts::CUTS, true), (BakeParts::INDIRECT, false), (BakeParts::ENVIRONMENT, true)] {
        let bake = BakeSettings { mode, ..window.0.state().work.document.bake.clone() };
        window.perform(Action::Edit { edit: Edit::Bake(bake.into()), label: "Bake type" });
        window.wait("a preview in that light", |s| {
            s.work.scene.baked_parts().is_some_and(|parts| parts.environment() == is_lit)
        });
        assert_eq!(window.0.state().work.scene.seen(), BakeStage::Unshadowed);
    }
}

#[test]
fn a_bake_begins_by_itself_if_that_is_wanted() {
    let place = Place::new();
    let mut window = place.window();
    window.0.state_mut().work.preferences.bakes_scenes = true;
    window.open(&place.path("scene.obj"));
    assert!(window.0.state().baking.progress().is_some() && !window.shows("is not baked yet"));
    window.perform(Action::Bake(BakeAction::Cancel));
    window.wait("the end", |s| s.baking.progress().is_none());
    assert!(window.0.state().work.scene.rendered().is_some(), "what there was stays in use");
    place.bake();
    window.open(&place.path("scene.obj"));
    assert!(window.0.state().baking.progress().is_none(), "negative control: there is a bake");
}

#[test]
fn what_is_baked_by_itself_is_kept_and_not_beside_the_scene() {
    let place = Place::new();
    let window = baked_by_itself(&place);
    assert!(!place.path("scene.cuts").exists());
    let state = window.0.state();
    assert_eq!((state.work.scene.seen(), &state.work.document.dataset), (BakeStage::Whole, &None));
    let kept = state.work.scene.kept_output.clone().unwrap();
    assert!(kept.is_file() && kept.starts_with(place.path("home/cache/bakes")));
    let mut again = place.window();
    again.open(&place.path("scene.obj"));
    assert_eq!(
        (again.0.state().work.scene.seen(), again.0.state().work.document.bake.lights),
        (BakeStage::Whole, few_lights().lights)
    );
    // Another version of the scene has another bake.
    std::fs::write(place.path("scene.obj"), super::SCENE.replace("0 0.6 0", "0 0.9 0")).unwrap();
    again.open(&place.path("scene.obj"));
    assert_eq!(again.0.state().work.scene.seen(), BakeStage::Unshadowed);
}

#[test]
fn a_bake_that_is_kept_is_written_beside_the_scene_without_baking_again() {
    let place = Place::new();
    let mut window = baked_by_itself(&place);
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    assert!(window.0.state().baking.progress().is_none());
    window.wait("the file", |s| s.work.messages.any_contains("Bake written"));
    assert_eq!(Dataset::read(&place.path("scene.cuts"), image::decode).unwrap().tree.len(), few_lights().lights);
    assert_eq!(window.0.state().work.document.dataset, Some(place.path("scene.cuts")));
    // With other settings it is baked.
    window.0.state_mut().work.document.bake.lights = 512;
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    window.wait("the bake", |s| s.baking.progress().is_none());
    assert_eq!(Dataset::read(&place.path("scene.cuts"), image::decode).unwrap().tree.len(), 512);
}

#[test]
fn a_draft_of_an_own_scene_outlives_its_bake() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    // The full bake takes a minute, and is canceled long before that.
    let long = BakeSettings { lights: 32_768, max_vertices: Some(100_000), ..few_lights() };
    window.0.state_mut().work.document.bake = long;
    window.bake_by_itself(true);
    window.wait("the draft", |s| s.work.scene.seen() == BakeStage::Draft);
    assert!(window.shows("Draft; full bake running"));
    let kept = draft_of(window.0.state().work.scene.kept_output.as_ref().unwrap());
    window.wait("the file of the draft", |_| Dataset::read(&kept, image::decode).is_ok());
    window.perform(Action::Bake(BakeAction::Cancel));
    window.wait("the end", |s| s.baking.progress().is_none());
    assert_eq!(window.0.state().work.scene.seen(), BakeStage::Draft, "it stays in use");
    let mut later = place.window();
    later.open(&place.path("scene.obj"));
    assert_eq!(later.0.state().work.scene.seen(), BakeStage::Draft);
    later.wait("its badge", |s| s.picture.shown().is_some());
    assert!(later.shows("Draft"));
}

#[test]
fn a_bake_that_is_kept_has_the_look_of_the_scene_as_it_is_now() {
    let place = Place::new();
    let paint = |color: &str| {
        let text = format!("newmtl paint\nKd {color}\n");
        std::fs::write(place.path("look.mtl"), text).unwrap();
    };
    paint("1 0 0");
    std::fs::write(place.path("scene.obj"), format!("mtllib look.mtl\nusemtl paint\n{}", super::SCENE)).unwrap();
    let window = baked_by_itself(&place);
    let color = |window: &super::Window| window.0.state().work.document.materials[0].parameters.color("base_color");
    assert_eq!(color(&window), Vec3::X);
    paint("0 0 1");
    let mut again = place.window();
    again.open(&place.path("scene.obj"));
    assert_eq!(
        (again.0.state().work.scene.seen(), color(&again)),
        (BakeStage::Whole, Vec3::Z),
        "colors make no bake stale"
    );
}

#[test]
fn a_posed_bake_that_is_kept_is_seen_as_it_was_baked() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.document.bake = few_lights();
    let moved = Pose { translate: Vec3::X * 0.2, ..Pose::AS_BAKED };
    window.0.state_mut().work.document.poses.set(1, moved);
    window.bake_by_itself(false);
    window.wait("the bake", |s| s.baking.progress().is_none());
    let mut again = place.window();
    again.open(&place.path("scene.obj"));
    let state = again.0.state();
    assert_eq!((state.work.scene.seen(), state.work.document.poses.of(1)), (BakeStage::Whole, moved));
    assert!(state.pose.poses_since(&state.work, state.work.scene.shown().unwrap()).is_empty());
}

#[test]
fn a_scene_that_changes_during_its_bake_is_seen_as_it_is() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.document.bake = few_lights();
    window.bake_by_itself(false);
    // Read again before the bake is taken.
    std::fs::write(place.path("scene.obj"), super::SCENE.replace("0 0.6 0", "0 0.9 0")).unwrap();
    let changed = Imported::read(&place.path("scene.obj"), &Default::default()).unwrap();
    let hash = changed.hash.clone();
    window.0.state_mut().work.scene_changed(&place.path("scene.obj"), changed);
    window.wait("the bake", |s| s.baking.progress().is_none());
    let state = window.0.state();
    assert!(state.work.scene.is_stale() && state.work.scene.seen() == BakeStage::Unshadowed);
    assert_eq!(state.work.scene.rendered().unwrap().dataset.scene_hash, hash);
    assert!(state.work.scene.kept_output.as_ref().unwrap().to_string_lossy().contains(&hash[..16]));
}
