//! A ground that is chosen: seen at once, baked, and hidden again.

use super::{Place, Window, few_lights};
use crate::{
    actions::{Action, BakeAction, FileAction},
    document::Edit,
    workspace::BakeStage,
};
use glam::Vec3;
use lapidary_core::{dataset::BakeSettings, ground::Ground};
use lapidary_interchange::image;

fn choose(window: &mut Window, ground: Ground) {
    let bake = BakeSettings { ground, ..window.0.state().work.document.bake.clone() };
    window.perform(Action::Edit { edit: Edit::Bake(Box::new(bake)), label: "Ground" });
    window.perform(Action::EndGesture);
}

/// The scene with a bake without a ground; with `by_itself` scenes are baked automatically.
fn opened(place: &Place, by_itself: bool) -> Window {
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.preferences.bakes_scenes = by_itself;
    assert_eq!((window.0.state().work.scene.seen(), has_ground(&window)), (BakeStage::Whole, false));
    window
}

fn has_ground(window: &Window) -> bool {
    window.0.state().work.scene.rendered().unwrap().has_ground()
}

fn is_baking(window: &Window) -> bool {
    window.0.state().baking.progress().is_some()
}

#[test]
fn a_ground_that_is_chosen_is_seen_at_once_and_baked() {
    let place = Place::new();
    let mut window = opened(&place, true);
    choose(&mut window, Ground::Shadow);
    assert!(window.0.state().work.scene.seen() == BakeStage::Unshadowed && has_ground(&window) && is_baking(&window));
    // The running bake has it.
    choose(&mut window, Ground::Off);
    choose(&mut window, Ground::Shadow);
    assert!(!window.0.state().baking.run.as_ref().unwrap().job.is_cancelling());
    window.wait("the bake", |s| s.baking.progress().is_none());
    assert!(window.0.state().work.scene.seen() == BakeStage::Whole && has_ground(&window));
    let ground = window.0.state().work.document.materials.last().unwrap().name.clone();
    assert_eq!(ground, "Ground");
    // It is hidden and shown without another bake.
    for other in [Ground::On, Ground::Off, Ground::Shadow] {
        choose(&mut window, other);
        assert!(
            window.0.state().work.scene.seen() == BakeStage::Whole && has_ground(&window) && !is_baking(&window),
            "{other:?}"
        );
        let look = window.0.state().look([8, 8]).unwrap();
        assert_eq!(look.view.ground, other);
    }
}

#[test]
fn without_automatic_bakes_a_ground_is_seen_without_shadows_until_it_goes() {
    let place = Place::new();
    let mut window = opened(&place, false);
    let materials = window.0.state().work.document.materials.len();
    choose(&mut window, Ground::On);
    assert!(window.0.state().work.scene.seen() == BakeStage::Unshadowed && has_ground(&window) && !is_baking(&window));
    window.0.state_mut().work.document.materials[materials].parameters.set("base_color", Vec3::X);
    choose(&mut window, Ground::Off);
    assert!(window.0.state().work.scene.seen() == BakeStage::Whole && !has_ground(&window));
    assert_eq!(window.0.state().work.document.materials.len(), materials);
    let session = place.path("look.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    choose(&mut window, Ground::On);
    let color = |window: &Window| window.0.state().work.document.materials[materials].parameters.color("base_color");
    assert_eq!(color(&window), Vec3::X, "its material is kept");
    let mut again = place.window();
    again.open(&session);
    assert_eq!(again.0.state().work.document.materials.len(), materials);
    choose(&mut again, Ground::On);
    assert_eq!(color(&again), Vec3::X, "in sessions too");
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.scene.seen(), BakeStage::Whole);
}

#[test]
fn a_bake_that_the_user_began_ends_before_that_of_a_ground_begins() {
    let place = Place::new();
    let mut window = opened(&place, true);
    window.0.state_mut().work.document.bake = BakeSettings { lights: 512, ..few_lights() };
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    let output = window.0.state().baking.run.as_ref().unwrap().output.clone();
    choose(&mut window, Ground::Shadow);
    let run = window.0.state().baking.run.as_ref().unwrap();
    assert!(run.output == output && !run.job.is_cancelling());
    window.wait("both", |s| s.baking.progress().is_none() && s.work.scene.seen() == BakeStage::Whole);
    assert!(has_ground(&window));
    let written = lapidary_core::dataset::Dataset::read(&output, image::decode).unwrap();
    assert_eq!((written.tree.len(), written.scene.mesh.ground), (512, None));
}

#[test]
fn a_bake_that_ended_for_a_ground_begins_anew_whatever_is_chosen_by_then() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.preferences.bakes_scenes = true;
    window.0.state_mut().work.document.bake = BakeSettings { lights: 8192, max_vertices: Some(20_000), ..few_lights() };
    window.bake_by_itself(false);
    for ground in [Ground::Shadow, Ground::Off] {
        let bake =
            BakeSettings { ground, lights: 256, max_vertices: None, ..window.0.state().work.document.bake.clone() };
        window.0.state_mut().work.document.bake = bake;
        let state = window.0.state_mut();
        state.baking.follow_ground(&mut state.work);
    }
    assert!(window.0.state().baking.run.as_ref().unwrap().job.is_cancelling());
    window.wait("another bake", |s| s.work.scene.seen() == BakeStage::Whole && s.baking.progress().is_none());
    assert_eq!(window.0.state().work.scene.shown().unwrap().dataset.tree.len(), 256);
    // A bake that the user cancels stays canceled.
    window.0.state_mut().work.document.bake.lights = 8192;
    window.bake_by_itself(false);
    window.perform(Action::Bake(BakeAction::Cancel));
    window.wait("the end", |s| s.baking.progress().is_none());
    window.0.run_steps(3);
    assert!(!is_baking(&window));
}
