//! Comparisons of a small scene on a thread.

use super::*;
use crate::jobs::testing::{silent, wait_for};
use glam::Vec3;
use lapidary_core::{camera::Camera, test_scenes};
use lapidary_interchange::image;
use lapidary_render::{Appearance, CpuBackend, Post, compare::compare, test_looks::plain_look};
use std::time::Duration;

fn start() -> ComparisonThread {
    ComparisonThread::start(Arc::new(|| Ok(Box::new(CpuBackend::new()))), silent())
}

fn comparison(kind: ReferenceKind) -> ComparisonRequest {
    let baked: Baked = test_scenes::dataset(&["a"], &[]).into();
    let mut look = plain_look(1);
    look.appearance = Appearance::of(&baked.dataset.scene);
    look.view.camera = Camera::look_at(Vec3::new(0.3, 2.0, 0.3), Vec3::new(0.3, 0.0, 0.3), 60.0);
    ComparisonRequest { baked: Some(baked), look, kind, scale: 2, region: None }
}

/// All events until the reference is finished or fails.
fn outcome(thread: &mut ComparisonThread) -> Vec<ComparisonEvent> {
    let mut events = Vec::new();
    wait_for("the reference", || {
        events.extend(thread.events());
        let ends = |e: &ComparisonEvent| match e {
            ComparisonEvent::Reference(reference) => reference.finished,
            ComparisonEvent::Failed(_) => true,
            _ => false,
        };
        events.iter().any(ends).then_some(())
    });
    events
}

fn pictures(events: &[ComparisonEvent]) -> (Arc<TestPicture>, ReferencePicture) {
    let test = events.iter().find_map(|e| if let ComparisonEvent::Test(test) = e { Some(test.clone()) } else { None });
    let last = events.iter().rev();
    let reference =
        last.filter_map(|e| if let ComparisonEvent::Reference(r) = e { Some(r.clone()) } else { None }).next();
    (test.expect("a picture with cuts"), reference.expect("a reference"))
}

fn failure(events: &[ComparisonEvent]) -> &str {
    let failed =
        events.iter().find_map(|e| if let ComparisonEvent::Failed(text) = e { Some(text.as_str()) } else { None });
    failed.expect("a failure")
}

#[test]
fn both_references_of_an_open_scene_agree_with_the_cuts_and_another_scene_would_not() {
    let mut thread = start();
    for kind in [ReferenceKind::Samples, ReferenceKind::Paths { spp: 64 }] {
        thread.request(comparison(kind.clone()));
        let (test, reference) = pictures(&outcome(&mut thread));
        assert_eq!((test.image.size, reference.image.size, reference.step), ([32, 24], [32, 24], 1));
        assert!(test.coverage.contains(&0.0) && test.coverage.contains(&1.0));
        assert_eq!(reference.noise.is_some(), kind != ReferenceKind::Samples);
        let rel_rmse = |test: &Image| compare(test, &reference.image).unwrap().rel_rmse;
        assert!(rel_rmse(&test.image) < 0.1, "{kind:?}: {}", rel_rmse(&test.image));
        let mut darker = test.image.clone();
        darker.pixels.iter_mut().for_each(|p| *p *= 0.7);
        assert!(rel_rmse(&darker) > 0.2, "negative control");
    }
    assert_eq!(thread.progress(), 1.0);
}

#[test]
fn exposure_begins_nothing_anew_and_light_does() {
    let mut thread = start();
    let first = comparison(ReferenceKind::Paths { spp: 2 });
    assert!(thread.request(first.clone()));
    outcome(&mut thread);
    let mut other = first.clone();
    other.look.post = Post { exposure: 2.0, ..Post::default() };
    assert!(!thread.request(other.clone()));
    other.look.illumination.rotation = 1.0;
    assert!(thread.request(other.clone()));
    assert!(thread.request(ComparisonRequest { kind: ReferenceKind::Samples, ..other }));
    thread.stop();
    assert!(thread.request(first), "what was stopped begins again");
}

#[test]
fn a_pause_holds_the_reference_and_a_new_request_ends_it() {
    let mut thread = start();
    thread.request(comparison(ReferenceKind::Paths { spp: 1_000_000 }));
    wait_for("a first pass", || (thread.progress() > 0.0).then_some(()));
    thread.pause(true);
    wait_for("the end of the pass that is under way", || thread.control.is_waiting().then_some(()));
    let held = thread.progress();
    std::thread::sleep(Duration::from_millis(200));
    assert!(thread.is_paused() && thread.progress() == held);
    thread.pause(false);
    wait_for("more passes", || (thread.progress() > held).then_some(()));
    thread.pause(true);
    thread.request(comparison(ReferenceKind::Paths { spp: 2 }));
    assert!(!thread.is_paused());
    let (_, reference) = pictures(&outcome(&mut thread));
    assert!(reference.finished, "the million paths of before hold nothing up");
}

#[test]
fn other_work_holds_the_reference_even_a_new_one() {
    let mut thread = start();
    thread.hold(true);
    thread.request(comparison(ReferenceKind::Paths { spp: 4 }));
    wait_for("the thread to wait", || thread.control.is_waiting().then_some(()));
    let held = thread.progress();
    std::thread::sleep(Duration::from_millis(200));
    assert!(thread.is_held() && !thread.is_paused() && thread.progress() == held && held < 1.0);
    thread.hold(false);
    let (_, reference) = pictures(&outcome(&mut thread));
    assert!(reference.finished);
}

#[test]
fn a_region_is_traced_alone() {
    let mut thread = start();
    let region = Some(Region { x: 8, y: 4, width: 12, height: 8 });
    thread.request(ComparisonRequest { region, ..comparison(ReferenceKind::Paths { spp: 1 }) });
    let (_, reference) = pictures(&outcome(&mut thread));
    let lit = |x: u32, y: u32| reference.image.at(x as usize, y as usize) != Vec3::ZERO;
    let inside = |x: u32, y: u32| (8..20).contains(&x) && (4..12).contains(&y);
    let pixels = || (0..24).flat_map(|y| (0..32).map(move |x| (x, y)));
    assert!(pixels().all(|(x, y)| !lit(x, y) || inside(x, y)));
    assert!(pixels().any(|(x, y)| lit(x, y)));
}

#[test]
fn another_look_is_compared_in_the_same_view() {
    let mut thread = start();
    let look = |number: u64, exposure: f32| {
        let mut look = comparison(ReferenceKind::Samples).look;
        look.illumination.intensity *= exposure;
        // Of another place, which the comparison does not take.
        look.view.camera.eye = Vec3::splat(9.0);
        ReferenceKind::Look(OtherLook { number, make: Arc::new(move || Ok(look.clone())) })
    };
    let mut compared = |number: u64, exposure: f32| {
        thread.request(comparison(look(number, exposure)));
        let (test, reference) = pictures(&outcome(&mut thread));
        compare(&reference.image, &test.image).unwrap().rel_rmse
    };
    assert_eq!(compared(1, 1.0), 0.0);
    assert!(compared(2, 2.0) > 0.1, "negative control: twice the light");
    let fails = OtherLook { number: 3, make: Arc::new(|| anyhow::bail!("no such map")) };
    thread.request(comparison(ReferenceKind::Look(fails)));
    assert!(failure(&outcome(&mut thread)).contains("no such map"));
}

#[test]
fn a_file_is_compared_in_its_own_size_and_a_bad_one_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("truth.exr");
    image::write(&Image::filled([20, 15], Vec3::ONE), &path).unwrap();
    let mut thread = start();
    thread.request(comparison(ReferenceKind::File(path.clone())));
    let (test, reference) = pictures(&outcome(&mut thread));
    assert_eq!((test.image.size, reference.image.size), ([20, 15], [20, 15]));
    std::fs::write(&path, b"no picture").unwrap();
    thread.stop();
    thread.request(comparison(ReferenceKind::File(path)));
    assert!(failure(&outcome(&mut thread)).contains("cannot be read"));
    thread.request(comparison(ReferenceKind::File(folder.path().join("missing.exr"))));
    assert!(failure(&outcome(&mut thread)).contains("missing.exr"));
    let nothing = comparison(ReferenceKind::Samples);
    thread.request(ComparisonRequest { baked: None, ..nothing });
    assert!(failure(&outcome(&mut thread)).contains("open a scene"));
}
