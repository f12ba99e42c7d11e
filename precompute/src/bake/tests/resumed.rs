//! Bakes that go on from a checkpoint.

use super::*;
use crate::meshless::transport::steps::KeepsRows;
use lapidary_core::camera::Camera;

#[test]
fn a_cancelled_bake_resumes_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(5), ..job(folder.path(), "a.cuts") };
    let whole = contents(
        &bake(scene(), &BakeJob { output: folder.path().join("whole.cuts"), ..job.clone() }, &Silent).unwrap(),
    );
    let interrupted = bake(scene(), &job, &CancelIn::phase(Phase::Visibility));
    assert!(matches!(interrupted, Err(BakeError::Cancelled)));
    assert!(!job.output.exists());
    let partial = Checkpoint::folder_of(&job.output);
    assert!(partial.join("chunk-00000.bin").exists(), "what was finished is kept");
    let resumed = bake(scene(), &BakeJob { resume: true, ..job.clone() }, &Silent).unwrap();
    assert_eq!(contents(&resumed), whole);
    assert!(!partial.exists());
    assert_eq!(contents(&Dataset::read(&job.output).unwrap()), whole);
}

#[test]
fn the_operator_resumes_within_its_steps_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let parts = |dataset: &Dataset| {
        let bake = dataset.meshless.clone().unwrap();
        (bake.basis.points().to_vec(), bake.transport)
    };
    let job = |name| indirect_job(folder.path(), name, BakeParts::MESHLESS);
    let whole = bake(interior(), &job("a.cuts"), &Silent).unwrap();
    let job = job("b.cuts");
    let interrupted = || {
        assert!(matches!(bake(interior(), &job, &CancelIn::phase(Phase::Transport)), Err(BakeError::Cancelled)));
        let partial = Checkpoint::folder_of(&job.output);
        assert!(partial.join("transport-00000.bin").exists() && !partial.join("transport-00001.bin").exists());
    };
    interrupted();
    let resume = BakeJob { resume: true, ..job.clone() };
    assert_eq!(parts(&bake(interior(), &resume, &Silent).unwrap()), parts(&whole));

    // Negative control: what was kept is used.
    interrupted();
    let checkpoint = Checkpoint::open(&job.output, &whole.scene_hash, &job.settings).unwrap().unwrap();
    let coarsest = whole.report.meshless.as_ref().unwrap().gathered[0];
    let mut rows = checkpoint.load_rows(0, coarsest).unwrap();
    rows[0].clear();
    checkpoint.store_rows(0, &rows).unwrap();
    assert_ne!(parts(&bake(interior(), &resume, &Silent).unwrap()), parts(&whole));
}

#[test]
fn chunks_about_another_room_are_not_used_when_the_camera_has_moved() {
    let folder = tempfile::tempdir().unwrap();
    let half = Vec3::new(1.0, 0.7, 0.8);
    let rooms = |eye: Vec3| {
        let mut triangles = [room(Vec3::ZERO, half), room(Vec3::X * 4.0, half)].concat();
        triangles.extend(cuboid(Vec3::new(0.3, -0.4, 0.2), Vec3::splat(0.2)));
        triangles.extend(cuboid(Vec3::new(3.6, -0.3, 0.1), Vec3::splat(0.2)));
        let mut scene = scene_of(&triangles);
        scene.cameras = vec![Camera::look_at(eye, eye + Vec3::Z, 40.0)];
        scene
    };
    let (first, second) = (Vec3::new(-0.3, 0.1, 0.0), Vec3::new(4.1, 0.1, 0.0));
    let job = |name| searching(indirect_job(folder.path(), name, BakeParts::ALL));
    let parts = |dataset: &Dataset| {
        let meshless = dataset.meshless.clone().unwrap();
        (indirect_contents(dataset), meshless.basis.points().to_vec(), meshless.transport)
    };
    let whole = bake(rooms(second), &job("a.cuts"), &Silent).unwrap();
    let job = job("b.cuts");
    assert!(matches!(bake(rooms(first), &job, &CancelIn::phase(Phase::Transport)), Err(BakeError::Cancelled)));
    let partial = Checkpoint::folder_of(&job.output);
    assert!(partial.join("source-chunk-00000.bin").exists() && partial.join("transport-00000.bin").exists());
    let told = Told::default();
    let moved = bake(rooms(second), &BakeJob { resume: true, ..job }, &told).unwrap();
    assert!(whole.report.indirect.as_ref().unwrap().viewpoint[0] > 3.0, "the camera decides");
    assert_eq!(parts(&moved), parts(&whole));
    let told = told.all().join("\n");
    assert!(told.contains("surface sources differ") && told.contains("meshless basis differ"), "{told}");
}

#[test]
fn a_checkpoint_of_other_points_is_discarded_aloud() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "a.cuts");
    let resume = BakeJob { resume: true, ..job.clone() };
    let resumed_after = |change: &dyn Fn(String) -> String| {
        assert!(bake(scene(), &job, &CancelIn::phase(Phase::Visibility)).is_err());
        let manifest = Checkpoint::folder_of(&job.output).join("bake.json");
        std::fs::write(&manifest, change(std::fs::read_to_string(&manifest).unwrap())).unwrap();
        let told = Told::default();
        (contents(&bake(scene(), &resume, &told).unwrap()), told.all().join("\n"))
    };
    let (whole, silent) = resumed_after(&|json| json);
    assert_eq!(silent, "");
    for change in [r#""points":1"#, r#""tree_order":[0,0,"#] {
        let (name, _) = change.split_once(':').unwrap();
        let (again, told) = resumed_after(&|json| json.replacen(&format!("{name}:"), change, 1).replacen(",[", ",", 1));
        assert!(told.contains("is discarded"), "{told}");
        assert_eq!(again, whole);
    }
}
