//! The thread with a renderer that only counts calls.

mod failures;
mod fake;

use super::*;
use fake::{Fake, Log, Shared};
use glam::Vec3;
use lapidary_core::{lights::Light, material::Material, scene::pose::Pose, test_scenes};
use lapidary_render::{
    Appearance, Backend, BackendError, Baked, BrdfSampling, Components, CpuBackend, DeviceCuts, Illumination, LitScene,
    Post, Remedy, STRIDES, Solution, Tiles, View, share_of_lattice, test_looks::plain_look,
};
use lapidary_studies::jobs::testing::{silent, wait_for};
use std::ops::Range;

fn dataset() -> Arc<Dataset> {
    test_scenes::dataset(&["a"], &[]).into()
}

fn request(aa: u32) -> RenderRequest {
    RenderRequest {
        baked: Some(dataset().into()),
        look: plain_look(aa),
        moving: false,
        may_pose: false,
        frame_budget_ms: 10.0,
        pointer: None,
    }
}

fn start(log: Log) -> (Shared, RenderThread) {
    let log: Shared = Arc::new(Mutex::new(log));
    let shared = log.clone();
    let factory = move || -> Result<Box<dyn Backend>, BackendError> {
        shared.lock().unwrap().made += 1;
        Ok(Box::new(Fake { log: shared.clone(), view: None }))
    };
    (log, RenderThread::start(Arc::new(factory), silent()))
}

/// Bands rendered and pictures displayed so far.
fn work(log: &Shared) -> (usize, u32) {
    let log = log.lock().unwrap();
    (log.sketched.len() + log.rows.len(), log.displays)
}

/// Waits for the complete full picture.
fn complete(thread: &mut RenderThread) -> RenderedFrame {
    wait_for("the full picture", || thread.frames().filter(|f| f.full_size && f.samples == f.of_samples))
}

fn failure(thread: &mut RenderThread) -> String {
    let failed = |event| if let RenderEvent::Failed(text) = event { Some(text) } else { None };
    wait_for("a failure", || thread.events().into_iter().find_map(failed))
}

/// Long enough for the thread to make a mistake.
fn linger() {
    std::thread::sleep(Duration::from_millis(250));
}

#[test]
fn a_coarse_picture_comes_first_and_all_samples_of_all_pixels_follow_once() {
    let (log, mut thread) = start(Log { micros_per_pixel: 10, ..Log::default() });
    let mut large = request(5);
    large.look.view.size = [192, 130];
    thread.request(large);
    let first = wait_for("a picture", || thread.frames());
    assert_eq!((first.size, first.full_size, first.of_samples), ([72, 49], false, 5));
    let last = complete(&mut thread);
    assert_eq!((last.size, last.samples, last.pixels.len()), ([192, 130], 5, 192 * 130));
    assert_eq!((last.backend.as_str(), last.light_revision), ("fake", 1));
    let log = log.lock().unwrap();
    assert_eq!((log.made, log.scenes, log.appearances, log.lights), (1, 1, 1, 1));
    assert_eq!(log.begun, [([72, 49], 1), ([192, 130], 5)]);
    let full = log.sketched.len() - 9 * STRIDES.len();
    for (stride, steps) in STRIDES.iter().zip(log.sketched[full..].chunks(9)) {
        assert!(steps.iter().all(|step| step.0 == *stride));
        let mut tiles: Vec<u32> = steps.iter().map(|step| step.1).collect();
        assert_eq!(tiles[0], 4, "the tile in the middle comes first");
        tiles.sort_unstable();
        assert_eq!(tiles, (0..9).collect::<Vec<_>>(), "{stride}");
    }
    for sample in 1..5 {
        let rows: Vec<u32> = log.rows.iter().filter(|r| r.0 == sample).flat_map(|r| r.1.clone()).collect();
        assert_eq!(rows, (0..130).collect::<Vec<_>>(), "sample {sample}");
    }
    assert!(log.displays <= 2 + 4 + 3, "at 1, 2, 4 and 5 samples, and once for each lattice");
}

#[test]
fn a_picture_that_is_done_in_time_is_made_without_lattices() {
    let (log, mut thread) = start(Log::default());
    let mut moved = RenderRequest { frame_budget_ms: 1e4, ..request(1) };
    thread.request(moved.clone());
    complete(&mut thread);
    let strides = |log: &Shared| std::mem::take(&mut log.lock().unwrap().sketched).into_iter().map(|step| step.0);
    assert!(strides(&log).any(|stride| stride == STRIDES[0]), "the first one tells how long it takes");
    moved.look.view.camera.eye.x = 3.0;
    thread.request(moved.clone());
    let first = wait_for("a picture", || thread.frames());
    assert!(first.full_size && first.samples == 1, "it is shown whole");
    assert!(strides(&log).all(|stride| stride == 1));
    moved.look.view.camera.eye.x = 4.0;
    thread.request(RenderRequest { frame_budget_ms: 0.0, ..moved });
    complete(&mut thread);
    assert!(strides(&log).any(|stride| stride == STRIDES[0]), "negative control: there is no time");
}

#[test]
fn an_edit_under_the_same_camera_is_shown_in_full_size_at_once() {
    let (log, mut thread) = start(Log { micros_per_pixel: 30, ..Log::default() });
    let mut edited = request(1);
    thread.request(edited.clone());
    complete(&mut thread);
    log.lock().unwrap().begun.clear();
    edited.look.illumination.rotation = 1.0;
    thread.request(edited.clone());
    let first = wait_for("a picture", || thread.frames());
    assert!(first.full_size && first.samples == 0, "some lattice");
    complete(&mut thread);
    assert_eq!(log.lock().unwrap().begun, [([64, 48], 1)]);
    edited.look.view.camera.eye.x = 3.0;
    thread.request(edited);
    assert!(!wait_for("a picture", || thread.frames()).full_size, "negative control: its pixels see something else");
}

#[test]
fn other_work_holds_the_full_picture_and_no_coarse_one() {
    let (log, mut thread) = start(Log { micros_per_pixel: 10, ..Log::default() });
    thread.hold(true);
    thread.request(request(2));
    assert!(!wait_for("a picture", || thread.frames()).full_size);
    linger();
    assert_eq!(log.lock().unwrap().begun, [([24, 18], 1)], "a coarse picture alone");
    thread.hold(false);
    assert_eq!(complete(&mut thread).samples, 2);
}

#[test]
fn another_bake_of_the_scene_replaces_the_picture_as_a_whole() {
    let (_log, mut thread) = start(Log { micros_per_pixel: 10, ..Log::default() });
    let first = request(2);
    thread.request(first.clone());
    complete(&mut thread);
    let frames = |thread: &mut RenderThread| {
        let mut frames = Vec::new();
        wait_for("the full picture", || {
            frames.extend(thread.frames().map(|frame| (frame.full_size, frame.samples)));
            frames.last().is_some_and(|last| *last == (true, 2)).then_some(())
        });
        frames
    };
    let is_whole = |frames: &[(bool, u32)]| frames.iter().all(|&(full_size, samples)| full_size && samples > 0);
    let rebaked = || RenderRequest { baked: Some(dataset().into()), ..first.clone() };
    let moved = |mut request: RenderRequest| {
        request.look.poses.set(0, Pose { translate: Vec3::X, ..Pose::AS_BAKED });
        request
    };
    let again = rebaked();
    thread.request(again.clone());
    let shown = frames(&mut thread);
    assert!(is_whole(&shown), "{shown:?}");
    thread.request(moved(again));
    assert!(!is_whole(&frames(&mut thread)), "negative control: an object moves");
    let baked_there = rebaked();
    thread.request(baked_there.clone());
    let shown = frames(&mut thread);
    assert!(is_whole(&shown), "a bake of where the object is: {shown:?}");
    thread.request(moved(baked_there));
    frames(&mut thread);
    thread.request(RenderRequest { moving: true, ..rebaked() });
    assert!(!is_whole(&frames(&mut thread)), "negative control: something moves meanwhile");
    let other = Dataset { scene_hash: "another scene".into(), ..(*dataset()).clone() };
    thread.request(RenderRequest { baked: Some(other.into()), ..first });
    assert!(
        frames(&mut thread).iter().any(|&(_, samples)| samples == 0),
        "negative control: another scene comes coarse"
    );
}

#[test]
fn a_preview_has_one_sample_until_it_is_none() {
    let (_log, mut thread) = start(Log::default());
    thread.set_preview(true);
    thread.request(request(4));
    wait_for("a sample", || thread.frames().filter(|f| f.full_size && f.samples == 1));
    linger();
    assert!(thread.frames().is_none_or(|frame| frame.samples == 1));
    thread.set_preview(false);
    assert_eq!(complete(&mut thread).samples, 4);
}

#[test]
fn nothing_is_rendered_when_nothing_changed() {
    let (log, mut thread) = start(Log::default());
    let same = request(2);
    thread.request(same.clone());
    complete(&mut thread);
    let before = work(&log);
    for _ in 0..5 {
        thread.request(same.clone());
        thread.request(RenderRequest { moving: true, ..same.clone() });
    }
    linger();
    assert!(thread.frames().is_none());
    assert_eq!(work(&log), before);
    let mut other = same;
    other.look.view.camera.eye.x = 9.0;
    thread.request(other);
    assert_eq!(complete(&mut thread).pixels[0][0], 9, "negative control: a change is rendered");
}

#[test]
fn local_lights_components_and_solution_are_rendered_and_the_same_ones_are_not() {
    let lights: Arc<[_]> = Arc::new([test_scenes::light()]);
    let mut old = request(1);
    old.look.lights = lights.clone();
    let change = |change: &dyn Fn(&mut RenderRequest)| {
        let mut new = old.clone();
        change(&mut new);
        old.redo(&new)
    };
    assert_eq!(change(&|r| r.look.lights = lights.clone()), Redo::NOTHING);
    let moved = Light { position: Vec3::splat(7.0), ..test_scenes::light() };
    assert!(change(&|r| r.look.lights = Arc::new([moved.clone()])).light.lights);
    assert!(change(&|r| r.look.components = Components::UNBOUNCED).shown);
    assert!(change(&|r| r.look.solution = Solution::Meshless).shown);
    assert_eq!(change(&|r| r.baked = Some(dataset().into())), Redo::ALL);
    let exposed = change(&|r| r.look.post.exposure = 1.0);
    assert_eq!(exposed, Redo { display: true, ..Redo::NOTHING }, "negative control");
}

#[test]
fn requests_are_the_same_until_anything_of_them_is_not() {
    let old = request(1);
    assert!(old.is_same(&old.clone()), "negative control");
    let edits: [fn(&mut RenderRequest); 13] = [
        |r| r.baked = Some(dataset().into()),
        |r| r.baked = None,
        |r| r.look.appearance.materials.push(Material::default()),
        |r| r.look.illumination.environment = Arc::new((*r.look.illumination.environment).clone()),
        |r| r.look.illumination.rotation = 0.1,
        |r| r.look.illumination.intensity = 2.0,
        |r| r.look.illum_cut = 17,
        |r| r.look.sampling = BrdfSampling::Once,
        |r| r.look.view.aa = 2,
        |r| r.look.post.exposure = 1.0,
        |r| r.look.components.direct = false,
        |r| r.moving = true,
        |r| r.frame_budget_ms = 11.0,
    ];
    for (i, edit) in edits.into_iter().enumerate() {
        let mut new = old.clone();
        edit(&mut new);
        assert!(!old.is_same(&new) && !new.is_same(&old), "edit {i}");
    }
}

#[test]
fn local_light_is_given_when_it_changes_and_not_again_for_the_camera() {
    let (log, mut thread) = start(Log::default());
    let mut edited = request(1);
    thread.request(edited.clone());
    complete(&mut thread);
    edited.look.view.camera.eye.x = 4.0;
    thread.request(edited.clone());
    complete(&mut thread);
    edited.look.lights = Arc::new([test_scenes::light()]);
    edited.look.view.camera.eye.x = 5.0;
    thread.request(edited.clone());
    complete(&mut thread);
    edited.look.components.environment = false;
    edited.look.view.camera.eye.x = 6.0;
    thread.request(edited);
    complete(&mut thread);
    let log = log.lock().unwrap();
    let given: Vec<_> = log.local.iter().map(|l| (l.lights.len(), l.components.environment)).collect();
    assert_eq!(given, [(0, true), (1, true), (1, false)]);
    assert_eq!(log.lights, 1, "the environment is lit once");
}

#[test]
fn a_post_edit_only_displays() {
    let (log, mut thread) = start(Log::default());
    let mut edited = request(2);
    thread.request(edited.clone());
    complete(&mut thread);
    let (bands, displays) = work(&log);
    edited.look.post.exposure = 7.0;
    thread.request(edited);
    let shown = complete(&mut thread);
    assert_eq!(shown.pixels[0][1], 7);
    linger();
    assert_eq!(work(&log), (bands, displays + 1));
}

#[test]
fn an_edit_redoes_only_what_it_changed() {
    let (log, mut thread) = start(Log::default());
    let mut edited = request(1);
    let counts = |log: &Shared| {
        let log = log.lock().unwrap();
        (log.scenes, log.appearances, log.lights)
    };
    thread.request(edited.clone());
    assert_eq!(complete(&mut thread).light_revision, 1);
    assert_eq!(counts(&log), (1, 1, 1));
    edited.look.appearance.materials.push(Material::default());
    thread.request(edited.clone());
    assert_eq!(complete(&mut thread).light_revision, 1);
    assert_eq!(counts(&log), (1, 2, 1));
    edited.look.illumination.rotation = 1.0;
    thread.request(edited.clone());
    assert_eq!(complete(&mut thread).light_revision, 2);
    edited.look.illum_cut = 4;
    thread.request(edited.clone());
    assert_eq!(complete(&mut thread).lighting.max_nodes, 4);
    assert_eq!(counts(&log), (1, 2, 3));
    edited.look.view.mode = lapidary_render::ViewMode::Normals;
    thread.request(edited.clone());
    complete(&mut thread);
    assert_eq!(counts(&log), (1, 2, 3));
    edited.baked = Some(dataset().into());
    thread.request(edited);
    complete(&mut thread);
    assert_eq!(counts(&log), (2, 3, 4), "another scene needs everything again");
}

#[test]
fn a_moving_camera_gives_reduced_pictures_and_rest_the_full_one() {
    let (_log, mut thread) = start(Log { micros_per_pixel: 200, ..Log::default() });
    let mut moved = RenderRequest { moving: true, ..request(1) };
    for x in 1..=6 {
        moved.look.view.camera.eye.x = x as f32;
        thread.request(moved.clone());
        let frame = wait_for("a picture", || thread.frames().filter(|f| f.pixels[0][0] == x));
        assert!(!frame.full_size && frame.size[0] < 64, "{:?}", frame.size);
    }
    assert_eq!(complete(&mut thread).pixels[0][0], 6);
}

#[test]
fn a_picture_that_fits_the_budget_is_full_at_once_and_not_made_twice() {
    let (log, mut thread) = start(Log::default());
    let mut moved = RenderRequest { frame_budget_ms: 1e4, ..request(2) };
    thread.request(moved.clone());
    complete(&mut thread);
    log.lock().unwrap().begun.clear();
    moved.look.view.camera.eye.x = 5.0;
    thread.request(moved);
    wait_for("the full picture", || {
        let frame = thread.frames()?;
        assert!(frame.full_size);
        (frame.samples == 2).then_some(())
    });
    assert_eq!(log.lock().unwrap().begun, [([64, 48], 2)]);
}

#[test]
fn the_latest_request_wins_and_interrupts() {
    let (log, mut thread) = start(Log { micros_per_pixel: 100, ..Log::default() });
    let mut moved = request(64);
    thread.request(moved.clone());
    wait_for("the full picture to begin", || (log.lock().unwrap().begun.len() == 2).then_some(()));
    for x in 0..100 {
        moved.look.view.camera.eye.x = x as f32;
        thread.request(moved.clone());
    }
    wait_for("the newest", || thread.frames().filter(|f| f.pixels[0][0] == 99));
    let log = log.lock().unwrap();
    assert!(log.begun.len() <= 5, "most of the hundred were never begun: {:?}", log.begun);
    assert!(log.rows.iter().all(|r| r.0 <= 1), "the first picture was left long before its 64 samples");
}

#[test]
fn pictures_are_shown_while_requests_keep_coming() {
    let (_log, mut thread) = start(Log { micros_per_pixel: 30, ..Log::default() });
    let mut turned = RenderRequest { moving: true, ..request(1) };
    thread.request(turned.clone());
    complete(&mut thread);
    let mut shown = 0;
    for i in 0..100 {
        turned.look.illumination.rotation = i as f32;
        thread.request(turned.clone());
        std::thread::sleep(Duration::from_millis(4));
        shown += usize::from(thread.frames().is_some());
    }
    assert!(shown >= 5, "{shown}");
}

#[test]
fn the_picture_is_read_when_it_is_complete_and_not_at_all_without_a_scene() {
    let (_log, mut thread) = start(Log { micros_per_pixel: 5, ..Log::default() });
    let answer = |thread: &mut RenderThread| {
        wait_for("the answer", || match thread.events().pop() {
            Some(RenderEvent::Picture { id, result }) => Some((id, result)),
            _ => None,
        })
    };
    thread.request(RenderRequest { baked: None, ..request(4) });
    thread.read_picture(1);
    let (id, nothing) = answer(&mut thread);
    assert!(id == 1 && nothing.unwrap_err().contains("open a scene"));
    thread.request(request(4));
    thread.read_picture(2);
    let (id, picture) = answer(&mut thread);
    let picture = picture.unwrap();
    assert_eq!((id, picture.image.size, picture.coverage.len()), (2, [64, 48], 64 * 48));
    assert_eq!(complete(&mut thread).samples, 4);
}

#[test]
fn the_picture_of_the_cpu_is_that_of_the_headless_renderer() {
    let mut thread = on_cores();
    let mut request = request(3);
    let dataset = request.baked.clone().unwrap().dataset;
    request.look.appearance = Appearance::of(&dataset.scene);
    thread.request(request.clone());
    thread.read_picture(1);
    let picture = wait_for("the answer", || match thread.events().pop() {
        Some(RenderEvent::Picture { result, .. }) => Some(result.unwrap()),
        _ => None,
    });
    let backend: Box<dyn Backend> = Box::new(CpuBackend::new());
    let mut headless = LitScene::new(backend, dataset.into()).unwrap();
    assert!(picture.image == headless.show_whole(&request.look).unwrap().image);
    assert!(picture.coverage.iter().any(|&c| c > 0.0) && picture.coverage.contains(&0.0));
    request.look.view.aa = 1;
    assert!(picture.image != headless.show_whole(&request.look).unwrap().image, "negative control");
}

fn on_cores() -> RenderThread {
    let factory = || -> Result<Box<dyn Backend>, BackendError> { Ok(Box::new(CpuBackend::new())) };
    RenderThread::start(Arc::new(factory), silent())
}

/// One sample of a scene, and time enough for it.
fn unhurried() -> RenderRequest {
    let mut request = RenderRequest { frame_budget_ms: 1e4, ..request(1) };
    request.look.appearance = Appearance::of(&dataset().scene);
    request
}

/// The same request while its object is dragged `x` meters away.
fn dragged(still: &RenderRequest, x: f32) -> RenderRequest {
    let mut request = RenderRequest { moving: true, ..still.clone() };
    request.look.poses.set(0, Pose { translate: Vec3::X * x, ..Pose::AS_BAKED });
    request
}

#[test]
fn a_pose_is_lit_coarsely_while_it_is_dragged_and_as_finely_as_can_be_at_rest() {
    let (mut thread, still) = (on_cores(), unhurried());
    thread.request(dragged(&still, 0.1));
    assert_eq!(complete(&mut thread).detail, Some(ImplicitDetail::OF_A_DRAG));
    thread.request(RenderRequest { moving: false, ..dragged(&still, 0.1) });
    let fine = wait_for("the finest", || thread.frames().filter(|f| f.detail == Some(ImplicitDetail::FINEST)));
    assert!(fine.full_size && fine.samples == fine.of_samples);
    let mut orbited = dragged(&still, 0.1);
    orbited.look.view.camera.eye.x += 0.1;
    thread.request(orbited);
    assert_eq!(complete(&mut thread).detail, Some(ImplicitDetail::FINEST), "another view has the same light");
    thread.request(dragged(&still, 0.2));
    let coarse = complete(&mut thread).detail;
    assert!(coarse.is_some_and(|detail| detail < ImplicitDetail::FINEST), "negative control: {coarse:?}");
    thread.request(still);
    assert_eq!(complete(&mut thread).detail, None, "nothing is posed");
}

#[test]
fn a_pose_is_lit_more_coarsely_where_the_frame_time_does_not_suffice() {
    let (mut thread, still) = (on_cores(), unhurried());
    let mut x = 0.0;
    let mut drag_until = |detail: ImplicitDetail, frame_budget_ms: f32| {
        wait_for("another detail", || {
            x += 0.01;
            thread.request(RenderRequest { frame_budget_ms, ..dragged(&still, x) });
            let step = wait_for("a step", || thread.frames());
            (step.detail == Some(detail)).then_some(())
        });
    };
    drag_until(ImplicitDetail::LADDER[0], 0.01);
    drag_until(ImplicitDetail::FINEST, 1e4);
}
