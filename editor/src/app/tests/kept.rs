//! Work is kept: recovered work, edits while a file opens, sessions of scenes without a bake, bakes.

use super::{Place, Window, few_lights};
use crate::{
    actions::{Action, BakeAction, EnvironmentAction, FileAction},
    bake::panel::BakeStatus,
    document::{
        Document, TextureEntry,
        autosave::{self, Autosave},
        session,
    },
    jobs::opening::{Consent, Opened, Ready, Target, open},
};
use lapidary_core::{
    dataset::BakeParts,
    image::Image,
    texture::{Texture, TextureSlot},
};
use lapidary_interchange::image;
use lapidary_precompute::{BakeJob, Event, Leftover, Observer, Phase, Silent, bake, resolve};
use std::{
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant},
};

/// A scene whose floor has a picture.
fn textured(place: &Place) -> PathBuf {
    image::write(&Image::filled([2, 2], glam::Vec3::X), &place.path("paint.png")).unwrap();
    std::fs::write(place.path("look.mtl"), "newmtl paint\nKd 1 1 1\nmap_Kd paint.png\n").unwrap();
    let text = "mtllib look.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 3/3 2/2\n";
    std::fs::write(place.path("textured.obj"), text).unwrap();
    place.path("textured.obj")
}

fn opened(place: &Place, target: Target) -> Box<Ready> {
    match open(target, &place.path("home/cache/bakes"), &Consent::default()).unwrap() {
        Opened::Ready(ready) => ready,
        Opened::Missing { loaded, .. } => panic!("missing: {:?}", loaded.missing),
        Opened::Outside { names, .. } => panic!("outside: {names:?}"),
    }
}

fn bake_into(ready: &Ready) {
    let output = ready.bake_output.clone().unwrap();
    std::fs::create_dir_all(output.parent().unwrap()).unwrap();
    let job = BakeJob::new(resolve(few_lights()).unwrap(), output);
    bake((*ready.source.as_ref().unwrap().scene).clone(), &job, &Silent).unwrap();
}

fn is_stand_in(document: &Document) -> bool {
    let slot = document.materials[0].maps.get("base_color").unwrap();
    document.textures[slot.texture as usize].texture.texels == Texture::missing("").texels
}

#[test]
fn a_session_saved_before_the_first_bake_finds_bake_and_textures_later() {
    let place = Place::new();
    let scene = textured(&place);
    let first = opened(&place, Target::Bundled(scene.clone()));
    assert!(first.lacks_bake && first.baked.is_none() && !is_stand_in(&first.document));
    let file = place.path("look.lapidary");
    session::save(&first.document, &Default::default(), &file).unwrap();
    let again = opened(&place, Target::File(file.clone()));
    assert_eq!(again.bake_output, first.bake_output, "not beside the scene");
    assert!(again.baked.is_none() && !is_stand_in(&again.document));
    let mut window = place.window();
    window.open(&file);
    window.0.state_mut().work.document.bake = few_lights();
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    window.wait("the bake", |s| s.work.scene.shown().is_some() && s.baking.progress().is_none());
    assert!(!is_stand_in(&window.0.state().work.document) && first.bake_output.unwrap().is_file());
}

#[test]
fn a_bake_of_other_settings_of_the_bundled_scene_is_not_replaced() {
    let place = Place::new();
    let scene = textured(&place);
    bake_into(&opened(&place, Target::Bundled(scene.clone())));
    let again = opened(&place, Target::Bundled(scene.clone()));
    assert!(!again.lacks_bake && again.baked.is_some());
    assert_eq!(again.document.bake, few_lights());
    let text = std::fs::read_to_string(&scene).unwrap().replace("v 1 0 0", "v 2 0 0");
    std::fs::write(&scene, text).unwrap();
    assert!(opened(&place, Target::Bundled(scene.clone())).lacks_bake, "another scene");
}

#[test]
fn a_bundled_scene_with_lights_is_baked_for_their_bounce() {
    let place = Place::new();
    let scene = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../data/color-box/color-box.gltf"));
    let ready = opened(&place, Target::Bundled(scene.into()));
    assert!(ready.lacks_bake && ready.document.bake.mode == BakeParts::INDIRECT && ready.document.lights.len() == 1);
    let dark = opened(&place, Target::Bundled(textured(&place)));
    assert!(dark.lacks_bake && dark.document.bake.mode == BakeParts::ENVIRONMENT, "negative control");
}

#[test]
fn the_menu_opens_each_bundled_scene_by_its_name() {
    let place = Place::new();
    std::fs::copy(place.path("scene.obj"), place.path("second-scene.obj")).unwrap();
    let mut window = place.window();
    window.0.state_mut().bundled.scenes = ["scene.obj", "second-scene.obj"].map(|name| place.path(name)).into();
    for label in ["File", "Bundled scenes", "Second scene"] {
        window.click_containing(label);
    }
    window.wait("the scene", |s| s.work.document.scene.is_some());
    assert_eq!(window.0.state().work.document.scene, Some(place.path("second-scene.obj")));
    window.perform(Action::File(FileAction::OpenBundled(7)));
    assert!(window.has_said("--data DIR"));
}

#[test]
fn a_damaged_scene_does_not_keep_a_session_from_opening() {
    let place = Place::new();
    place.bake();
    let document = opened(&place, Target::File(place.path("scene.obj"))).document;
    session::save(&document, &Default::default(), &place.path("look.lapidary")).unwrap();
    std::fs::write(place.path("scene.obj"), "v 1 nonsense\n").unwrap();
    let ready = opened(&place, Target::File(place.path("look.lapidary")));
    assert!(ready.baked.is_some() && ready.source.is_none());
    assert!(ready.warnings.iter().any(|w| w.contains("scene.obj")), "{:?}", ready.warnings);
}

/// Stops a bake when the first chunk of cuts is there.
#[derive(Default)]
pub struct StopsInVisibility {
    tracing: AtomicBool,
    advanced: AtomicBool,
}

impl Observer for StopsInVisibility {
    fn event(&self, event: Event) {
        match event {
            Event::Started { phase, .. } => self.tracing.store(phase == Phase::Visibility, Ordering::Relaxed),
            Event::Advanced { .. } => self.advanced.store(self.tracing.load(Ordering::Relaxed), Ordering::Relaxed),
            Event::Warning { .. } => {}
        }
    }

    fn cancelled(&self) -> bool {
        self.advanced.load(Ordering::Relaxed)
    }
}

#[test]
fn only_a_bake_of_the_same_settings_is_resumed() {
    let place = Place::new();
    let scene = lapidary_interchange::import::import(&place.path("scene.obj")).unwrap().scene;
    let output = place.path("scene.cuts");
    let job = BakeJob { chunks: Some(4), ..BakeJob::new(resolve(few_lights()).unwrap(), output) };
    assert!(bake(scene, &job, &StopsInVisibility::default()).is_err());
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    assert_eq!(window.bake_status(), BakeStatus::Cancelled { leftover: Leftover::OfAnother });
    window.0.state_mut().work.document.bake = few_lights();
    assert_eq!(window.bake_status(), BakeStatus::Cancelled { leftover: Leftover::Fitting });
    window.perform(Action::Bake(BakeAction::Begin { resume: true }));
    window.wait("the bake", |s| s.work.scene.shown().is_some() && s.baking.progress().is_none());
    assert_eq!(window.bake_status(), BakeStatus::UpToDate);
}

/// An autosave of an ended process.
fn autosaved(place: &Place, document: &Document) -> PathBuf {
    let state = place.path("home/state");
    let mut autosave = Autosave::new(&state, Duration::ZERO);
    let history = crate::document::History::unsaved();
    let written = autosave.tick(Instant::now(), document, &history, &Default::default(), None);
    assert!(written.unwrap());
    let entry = std::fs::read_dir(&state).unwrap().next().unwrap().unwrap();
    let orphan = state.join("autosave-1-1.lapidary");
    std::fs::rename(entry.path(), &orphan).unwrap();
    assert_eq!(autosave::recoverable(&state).len(), 1);
    orphan
}

#[test]
fn recovered_work_is_kept_until_it_is_saved_elsewhere() {
    let place = Place::new();
    place.bake();
    let mut document = opened(&place, Target::File(place.path("scene.obj"))).document;
    document.materials[0].parameters.set("roughness", 0.125);
    let orphan = autosaved(&place, &document);
    let mut window = place.window();
    window.0.run_steps(2);
    window.click("Recover");
    window.wait("the recovered work", |s| s.opening.is_none() && !s.work.document.materials.is_empty());
    assert_eq!(window.roughness(), 0.125);
    assert!(window.0.state().work.is_modified() && orphan.is_file());
    window.perform(Action::File(FileAction::SaveAs(Some(place.path("saved.lapidary")))));
    assert!(!orphan.exists() && !window.0.state().work.is_modified());
}

#[test]
fn recovery_that_was_given_up_keeps_the_autosave() {
    let place = Place::new();
    place.bake();
    let mut document = opened(&place, Target::File(place.path("scene.obj"))).document;
    document.environment.spec = place.path("gone.hdr").to_string_lossy().into_owned();
    let orphan = autosaved(&place, &document);
    let mut window = place.window();
    window.0.run_steps(2);
    window.click("Recover");
    window.wait("the question", |s| !s.questions.waiting.is_empty());
    assert!(window.shows("Files are missing"));
    window.click("Cancel");
    window.open(&place.path("scene.obj"));
    window.perform(Action::File(FileAction::SaveAs(Some(place.path("other.lapidary")))));
    assert!(orphan.is_file(), "it is of another document");
}

#[test]
fn edits_made_while_a_file_opens_are_asked_about() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().open(Target::File(place.path("scene.cuts")));
    let ctx = window.0.ctx.clone();
    // Before the frame that collects the opened document.
    window.0.state_mut().perform(&ctx, Action::Environment(EnvironmentAction::Load(Some("sun-sky".into()))));
    window.wait("the file", |s| s.opening.is_none());
    assert!(window.shows("Save the changes?"));
    assert_eq!(window.0.state().work.document.environment.spec, "sun-sky");
    window.click("Discard");
    assert!(window.0.state().work.document.scene.is_none() && !window.0.state().work.is_modified());
}

#[test]
fn a_session_whose_texture_moved_is_relinked() {
    let place = Place::new();
    place.bake();
    let picture = place.path("red.png");
    image::write(&Image::filled([3, 3], glam::Vec3::X), &picture).unwrap();
    let mut document = opened(&place, Target::File(place.path("scene.obj"))).document;
    let texture = image::read_texture(&picture).unwrap().into();
    document.textures.push(TextureEntry { texture, file: Some(picture.clone()) });
    let texture = (document.textures.len() - 1) as u32;
    document.materials[0].maps.set("base_color", Some(TextureSlot { texture, ..Default::default() }));
    session::save(&document, &Default::default(), &place.path("look.lapidary")).unwrap();
    std::fs::create_dir(place.path("moved")).unwrap();
    std::fs::rename(&picture, place.path("moved/red.png")).unwrap();
    let mut window = place.window();
    window.open(&place.path("look.lapidary"));
    assert!(window.shows("Files are missing") && window.shows("red.png"));
    std::fs::create_dir(place.path("elsewhere")).unwrap();
    window.perform(Action::File(FileAction::Relink(Some(place.path("elsewhere")))));
    window.wait("the question again", |s| s.opening.is_none());
    assert!(window.shows("Files are missing") && window.has_said("Found 0 files; 1 still missing"));
    window.perform(Action::File(FileAction::Relink(Some(place.path("moved")))));
    window.wait("the session", |s| s.opening.is_none() && !s.work.document.materials.is_empty());
    assert!(!window.shows("Files are missing") && !is_stand_in(&window.0.state().work.document));
    let files: Vec<_> = window.0.state().work.document.textures.iter().filter_map(|t| t.file.clone()).collect();
    assert_eq!(files, [place.path("moved/red.png")]);
}

#[test]
fn a_scene_that_changes_on_disk_is_said_and_its_bake_is_marked() {
    let place = Place::new();
    place.bake();
    let mut window: Window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("the watch", |s| s.watcher.watched.contains(&place.path("scene.obj")));
    let change = || std::fs::write(place.path("scene.obj"), super::SCENE.replace("0 0.6 0", "0 0.95 0")).unwrap();
    window.wait_for_watch("the change", change, |s| s.work.scene.is_stale());
    assert!(window.has_said("The scene file has changed") && window.0.state().work.scene.shown().is_some());
}

/// A file of two scenes, of one and of two objects.
const TWO_SCENES: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"name": "Day", "nodes": [0]}, {"name": "Night/2", "nodes": [0, 1]}],
        "nodes": [{"name": "lamp", "mesh": 0}, {"name": "moon", "mesh": 0, "translation": [0, 0, 5]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

#[test]
fn another_scene_of_a_file_has_its_own_bake_and_sessions_keep_it() {
    let place = Place::new();
    let path = place.path("two.gltf");
    std::fs::write(&path, TWO_SCENES).unwrap();
    let day = opened(&place, Target::File(path.clone()));
    assert_eq!(day.document.scene_in_file, None);
    let source = day.source.unwrap();
    assert_eq!((source.scene.objects.len(), source.report.default_scene.as_deref()), (1, Some("Day")));
    assert_eq!(source.report.scenes, ["Day", "Night/2"]);
    assert_eq!(day.bake_output, Some(place.path("two.cuts")));
    let night = opened(&place, Target::SceneIn { path: path.clone(), scene: "Night/2".into() });
    assert_eq!(night.document.objects[..2], ["lamp", "moon"]);
    assert_eq!(night.bake_output, Some(place.path("two.Night%2f2.cuts")));
    let session = place.path("night.lapidary");
    session::save(&night.document, &night.unknown, &session).unwrap();
    let again = opened(&place, Target::File(session));
    assert_eq!(again.document.scene_in_file.as_deref(), Some("Night/2"));
    assert_eq!(again.source.unwrap().scene.objects.len(), 2);
    assert_eq!(again.bake_output, Some(place.path("two.Night%2f2.cuts")));
}
