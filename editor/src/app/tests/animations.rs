//! Clips of scene files play in the window, are baked at a time, and change on disk.

use super::{Place, Window, few_lights};
use crate::{
    actions::{Action, BakeAction, FileAction, PoseAction, SelectAction},
    app::state::EditorState,
    bake::stale_now,
    document::{Document, Edit},
    jobs::{Imported, opening::Target, render_thread::RenderRequest},
    viewport::gizmo::Tool,
};
use egui::{Event, Key, PointerButton};
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use lapidary_core::{
    animation::ClipTime,
    scene::{
        Scene,
        pose::{Objects, Pose},
    },
};
use serde_json::json;
use std::path::{Path, PathBuf};

const FLOOR: [f32; 12] = [-1.0, 0.0, -1.0, 1.0, 0.0, -1.0, 1.0, 0.0, 1.0, -1.0, 0.0, 1.0];
const PYRAMID: [f32; 15] = [-0.3, 0.0, -0.3, 0.3, 0.0, -0.3, 0.3, 0.0, 0.3, -0.3, 0.0, 0.3, 0.0, 0.6, 0.0];
const PYRAMID_OBJECT: u32 = 1;

/// Writes a floor and a pyramid, which the clip "slide" moves along X by `metres` in a second, if given.
fn write_sliding(path: &Path, metres: Option<f32>) {
    let slide = [0.0, 0.0, 0.0, metres.unwrap_or_default(), 0.0, 0.0];
    let floats = [&FLOOR[..], &PYRAMID, &[0.0, 1.0], &slide].concat();
    let indices: [u16; 18] = [0, 3, 2, 0, 2, 1, 0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    std::fs::write(path.with_extension("bin"), &bytes).unwrap();
    let (mut views, mut accessors, mut offset) = (Vec::new(), Vec::new(), 0);
    let parts = [(4, 3, 5126), (5, 3, 5126), (2, 1, 5126), (2, 3, 5126), (6, 1, 5123), (12, 1, 5123)];
    for (view, (count, width, component)) in parts.into_iter().enumerate() {
        let length = count * width * if component == 5126 { 4 } else { 2 };
        views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
        let kind = if width == 3 { "VEC3" } else { "SCALAR" };
        accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        offset += length;
    }
    for (accessor, half, height) in [(0, 1.0, 0.0), (1, 0.3, 0.6)] {
        accessors[accessor]["min"] = json!([-half, 0.0, -half]);
        accessors[accessor]["max"] = json!([half, height, half]);
    }
    let mesh =
        |positions, indices| json!({ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] });
    let mut file = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "name": "floor", "mesh": 0 }, { "name": "pyramid", "mesh": 1 }], "meshes": [mesh(0, 4), mesh(1, 5)],
        "buffers": [{ "uri": path.with_extension("bin").file_name().unwrap().to_str(), "byteLength": bytes.len() }],
        "bufferViews": views, "accessors": accessors,
    });
    if metres.is_some() {
        file["animations"] = json!([{
            "name": "slide", "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }],
            "samplers": [{ "input": 2, "output": 3 }],
        }]);
    }
    std::fs::write(path, file.to_string()).unwrap();
}

fn sliding(place: &Place, metres: Option<f32>) -> PathBuf {
    let path = place.path("sliding.gltf");
    write_sliding(&path, metres);
    path
}

fn at(seconds: f32) -> Option<ClipTime> {
    Some(ClipTime { clip: "slide".into(), seconds })
}

/// The middle of the pyramid's box in a scene.
fn middle(scene: &Scene) -> Vec3 {
    Objects::of(scene).center(PYRAMID_OBJECT)
}

/// The middle of the pyramid's box in pictures.
fn middle_shown(state: &EditorState) -> Vec3 {
    let baked = state.work.scene.rendered().unwrap();
    middle(&baked.posed(&state.pose.poses_since(&state.work, baked)).unwrap().dataset.scene)
}

fn opened(path: &Path, place: &Place) -> Window {
    let mut window = place.window();
    window.open(path);
    window.0.state_mut().work.document.bake = few_lights();
    window
}

fn bake(window: &mut Window) {
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    window.wait("the bake", |s| s.work.scene.shown().is_some() && s.baking.progress().is_none());
}

fn seconds(state: &EditorState) -> f32 {
    state.work.document.clip_time.as_ref().map_or(0.0, |time| time.seconds)
}

fn is_playing(window: &Window) -> bool {
    window.0.state().pose.timeline.playing
}

#[test]
fn a_scene_that_was_baked_at_a_time_is_seen_at_rest_and_at_other_times() {
    let place = Place::new();
    let mut window = opened(&sliding(&place, Some(0.5)), &place);
    window.perform(Action::Pose(PoseAction::ClipTime(at(1.0))));
    bake(&mut window);
    let state = window.0.state();
    assert!(
        state.pose.poses_since(&state.work, state.work.scene.shown().unwrap()).is_empty()
            && stale_now(&state.work).is_empty()
    );
    for (time, x) in [(at(1.0), 0.5), (None, 0.0), (at(0.5), 0.25), (at(0.0), 0.0)] {
        window.perform(Action::Pose(PoseAction::ClipTime(time.clone())));
        let shown = middle_shown(window.0.state());
        assert!(shown.distance(Vec3::new(x, 0.3, 0.0)) < 1e-5, "{time:?}: {shown}");
    }
}

#[test]
fn a_clip_plays_by_its_button_and_by_space_while_a_bake_goes_on() {
    let place = Place::new();
    let mut window = opened(&sliding(&place, Some(0.5)), &place);
    window.click("Play");
    assert!(is_playing(&window) && window.shows("Stop"));
    bake(&mut window);
    assert!(is_playing(&window), "the bake did not wait for its end");
    let baked_at = window.0.state().work.scene.shown().unwrap().dataset.scene.clip_time.clone();
    window.wait("time to go by", |s| s.work.document.clip_time != baked_at);
    window.0.key_press(Key::Space);
    window.0.run_steps(2);
    assert!(!is_playing(&window));
    let before = seconds(window.0.state());
    window.0.run_steps(3);
    assert_eq!(seconds(window.0.state()), before);
    window.0.key_press(Key::Space);
    window.wait("time to go by", |s| seconds(s) != before);
    window.click("Stop");
    assert!(!is_playing(&window));
}

#[test]
fn playing_ends_with_its_scene_and_begins_in_none_without_clips() {
    let place = Place::new();
    let path = sliding(&place, Some(0.5));
    let mut window = opened(&path, &place);
    window.perform(Action::Pose(PoseAction::Play));
    assert!(is_playing(&window), "negative control");
    window.open(&path);
    assert!(!is_playing(&window));
    window.perform(Action::Pose(PoseAction::Play));
    window.open(&place.path("scene.obj"));
    window.perform(Action::Pose(PoseAction::Play));
    assert!(!is_playing(&window) && window.0.state().work.document.clip_time.is_none());
}

#[test]
fn a_time_out_of_reach_is_told_below_controls_that_stay() {
    let place = Place::new();
    let mut window = opened(&sliding(&place, Some(1e30)), &place);
    window.perform(Action::Pose(PoseAction::ClipTime(at(0.0))));
    assert!(!window.shows("out of reach"), "negative control");
    window.perform(Action::Pose(PoseAction::ClipTime(at(1.0))));
    window.perform(Action::Pose(PoseAction::Play));
    let trouble = "out of reach, or to no place at all";
    assert!(window.shows(trouble) && window.shows("Loop"));
    let told = window.0.get_by_label_contains(trouble).rect();
    let stop = window.0.get_by_label("Stop").rect();
    assert!(told.top() >= stop.bottom() && told.right() < 1100.0, "{told:?} below {stop:?}");
    window.click("Stop");
    assert!(!is_playing(&window));
}

#[test]
fn pictures_of_a_scrubbed_clip_are_those_of_a_drag() {
    let place = Place::new();
    let mut window = opened(&sliding(&place, Some(0.5)), &place);
    window.perform(Action::Pose(PoseAction::ClipTime(at(0.5))));
    window.wait("a picture", |s| s.picture.shown().is_some());
    let is_moving =
        |window: &Window| window.0.state().picture.requests.last_sent().is_some_and(|sent: &RenderRequest| sent.moving);
    let button =
        |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: super::NONE };
    let slider = window.0.get_by_label("Clip position").rect().left_center() + egui::vec2(16.0, 0.0);
    assert!(!is_moving(&window), "negative control");
    window.frame_of([Event::PointerMoved(slider), button(slider, true)]);
    let beside = slider + egui::vec2(12.0, 0.0);
    window.frame_of([Event::PointerMoved(beside)]);
    assert!(is_moving(&window));
    assert_ne!(seconds(window.0.state()), 0.5);
    window.frame_of([button(beside, false)]);
    assert!(!is_moving(&window));
}

/// The position of the pyramid's handles.
fn handles(window: &mut Window) -> Vec3 {
    window.0.run_steps(2);
    let state = window.0.state();
    state.pose.movable(&state.work).unwrap().place(&state.work.document.poses)
}

#[test]
fn handles_lie_where_an_animation_takes_their_object_whatever_was_baked() {
    let place = Place::new();
    let mut window = opened(&sliding(&place, Some(0.5)), &place);
    window.perform(Action::Select(SelectAction::Object(Some(PYRAMID_OBJECT))));
    window.0.state_mut().pose.tool = Some(Tool::Turn);
    let turned = Pose { rotate_degrees: Vec3::Y * 90.0, translate: Vec3::Y * 0.2, ..Pose::AS_BAKED };
    for baked_at in [None, at(1.0), at(0.5)] {
        if baked_at.is_some() {
            window.perform(Action::Pose(PoseAction::ClipTime(baked_at)));
            bake(&mut window);
        }
        for time in [None, at(0.5), at(1.0)] {
            window.perform(Action::Pose(PoseAction::ClipTime(time.clone())));
            let (shown, found) = (middle_shown(window.0.state()), handles(&mut window));
            assert!(found.distance(shown) < 1e-4, "at {time:?}: {found} in place of {shown}");
        }
        window.perform(Action::Edit { edit: Edit::Poses([(PYRAMID_OBJECT, turned)].into()), label: "Turn object" });
    }
    assert!(handles(&mut window).distance(Vec3::new(0.0, 0.5, 0.0)) > 0.1, "negative control: its place at rest");
}

#[test]
fn keyframes_that_change_on_disk_are_seen_at_once() {
    let place = Place::new();
    let path = sliding(&place, Some(0.5));
    let mut window = opened(&path, &place);
    window.perform(Action::Pose(PoseAction::ClipTime(at(1.0))));
    let hash = window.0.state().work.scene.source.as_ref().unwrap().hash.clone();
    for (metres, x) in [(0.5, 0.5), (0.25, 0.25)] {
        change(&mut window, &path, Some(metres));
        assert!(middle_shown(window.0.state()).distance(Vec3::new(x, 0.3, 0.0)) < 1e-5);
    }
    assert_eq!(window.0.state().work.scene.source.as_ref().unwrap().hash, hash, "the mesh is the same");
}

/// Rewrites the scene file, and notifies the window.
fn change(window: &mut Window, path: &Path, metres: Option<f32>) {
    write_sliding(path, metres);
    let changed = Imported::read(path, &Default::default()).unwrap();
    window.0.state_mut().work.scene_changed(path, changed);
    window.0.run_steps(2);
}

#[test]
fn a_clip_that_the_file_does_not_have_any_more_is_left_out_with_a_warning() {
    let place = Place::new();
    let path = sliding(&place, Some(0.5));
    let mut window = opened(&path, &place);
    window.perform(Action::Pose(PoseAction::ClipTime(at(0.5))));
    let session = place.path("slide.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    change(&mut window, &path, Some(0.25));
    let words = "the file has no animation";
    assert!(window.0.state().work.document.clip_time == at(0.5) && !window.has_said(words), "negative control");
    change(&mut window, &path, None);
    assert!(window.0.state().work.document.clip_time.is_none() && window.has_said(words));
    let mut again = place.window();
    again.open(&session);
    assert!(again.0.state().work.document.clip_time.is_none() && again.has_said(words));
}

#[test]
fn a_bundled_scene_opens_at_the_time_and_in_the_place_that_were_baked() {
    let place = Place::new();
    let path = sliding(&place, Some(0.5));
    let raised = Pose { translate: Vec3::Y * 0.2, ..Pose::AS_BAKED };
    let opened = || {
        let mut window = place.window();
        window.0.state_mut().open(Target::Bundled(path.clone()));
        window.wait("the scene", |s| s.opening.is_none());
        window
    };
    let mut window = opened();
    window.0.state_mut().work.document.bake = few_lights();
    window.perform(Action::Pose(PoseAction::ClipTime(at(0.5))));
    window.perform(Action::Edit { edit: Edit::Poses([(PYRAMID_OBJECT, raised)].into()), label: "Move object" });
    bake(&mut window);
    let again = opened();
    let Document { poses, clip_time, .. } = &again.0.state().work.document;
    assert_eq!((poses.of(PYRAMID_OBJECT), clip_time), (raised, &at(0.5)));
    assert!(stale_now(&again.0.state().work).is_empty() && !again.shows("Preview"));
}

#[test]
fn a_clip_plays_on_its_timeline_and_sessions_keep_its_time() {
    let place = Place::new();
    let mut window = opened(&sliding(&place, Some(0.5)), &place);
    assert!(window.shows("Play"));
    window.perform(Action::Pose(PoseAction::ClipTime(at(0.5))));
    let moved = |s: &EditorState| {
        let baked = s.work.scene.rendered().unwrap();
        s.pose
            .poses_since(&s.work, baked)
            .moved()
            .map(|object| s.work.document.objects[object as usize].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(moved(window.0.state()), ["pyramid"]);
    assert!(window.shows("Preview: implicit visibility"));
    window.perform(Action::Pose(PoseAction::Play));
    window.wait("time to go by", |s| seconds(s) > 0.55);
    window.perform(Action::Pose(PoseAction::Play));
    window.perform(Action::Pose(PoseAction::ClipTime(at(0.75))));
    let session = place.path("slide.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    window.perform(Action::Pose(PoseAction::ClipTime(None)));
    assert!(moved(window.0.state()).is_empty(), "negative control: at rest");
    let mut again = place.window();
    again.open(&session);
    assert_eq!(again.0.state().work.document.clip_time, at(0.75));
    let mut other = place.window();
    other.open(&place.path("scene.obj"));
    assert!(!other.shows("Play"), "nothing moves there");
}
