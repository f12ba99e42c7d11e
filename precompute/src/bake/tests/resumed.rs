//! Bakes resumed from a checkpoint.

use super::*;
use crate::errors::CheckpointError;
use crate::{
    bake::checkpoint::{Content, Places, Series, Work},
    meshless::transport::steps::KeepsRows,
    vertices::sampler::bake_points,
};
use lapidary_core::camera::Camera;
use lapidary_interchange::image;

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
    assert_eq!(contents(&Dataset::read(&job.output, image::decode).unwrap()), whole);
}

#[test]
fn the_operator_resumes_within_its_steps_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let parts = |dataset: &Dataset| {
        let bake = dataset.meshless.clone().unwrap();
        (bake.basis.points().to_vec(), bake.transport.clone())
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

    // Negative control: kept chunks are used.
    interrupted();
    let content = Content::still(&whole.scene_hash);
    let checkpoint = Checkpoint::open(&job.output, &Work::All, &content, &job.settings).unwrap().unwrap();
    let coarsest = whole.report.meshless.as_ref().unwrap().gathered[0];
    let basis = &whole.meshless.as_ref().unwrap().basis;
    let kept = checkpoint.series(Series::Transport, Places::of(basis.points(), basis.radii()));
    let mut rows = kept.load_rows(0, coarsest, basis.senders().len()).unwrap();
    rows[0].clear();
    kept.store_rows(0, &rows).unwrap();
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
        (indirect_contents(dataset), meshless.basis.points().to_vec(), meshless.transport.clone())
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

/// A job whose bake was interrupted while it selected cuts.
fn interrupted(folder: &Path) -> BakeJob {
    let job = BakeJob { chunks: Some(5), ..job(folder, "a.cuts") };
    assert!(bake(scene(), &job, &CancelIn::phase(Phase::Visibility)).is_err());
    job
}

#[test]
fn a_checkpoint_of_other_points_is_discarded_aloud() {
    let folder = tempfile::tempdir().unwrap();
    let job = interrupted(folder.path());
    let resume = BakeJob { resume: true, ..job.clone() };
    let told = Told::default();
    let whole = bake(scene(), &resume, &told).unwrap();
    assert!(told.all().is_empty(), "negative control: {:?}", told.all());
    Checkpoint::create(
        &job.output,
        &Work::All,
        Content::still(&whole.scene_hash),
        &job.settings,
        1,
        1,
        whole.tree.order(),
    )
    .unwrap();
    let again = bake(scene(), &resume, &told).unwrap();
    assert!(told.all().join("").contains("is discarded"), "{:?}", told.all());
    assert_eq!(contents(&again), contents(&whole));
    assert_eq!(again.report.warnings, whole.report.warnings, "what became of the checkpoint is not in the dataset");
}

#[test]
fn a_changed_manifest_is_refused_and_nothing_is_baked_from_it() {
    let folder = tempfile::tempdir().unwrap();
    let job = interrupted(folder.path());
    let manifest = Checkpoint::folder_of(&job.output).join("bake.json");
    let whole = std::fs::read_to_string(&manifest).unwrap();
    let resume = BakeJob { resume: true, ..job };
    for (key, changed) in [("\"points\":", "\"points\":1"), ("\"chunks\":", "\"chunks\":1"), ("[", "[0")] {
        let text = whole.replacen(key, changed, 1);
        assert_ne!(text, whole);
        std::fs::write(&manifest, text).unwrap();
        let refused = bake(scene(), &resume, &Silent).unwrap_err();
        assert!(matches!(refused, BakeError::Checkpoint(CheckpointError::Damaged { .. })), "{refused}");
    }
    std::fs::write(&manifest, whole).unwrap();
    assert!(bake(scene(), &resume, &Silent).is_ok(), "negative control");
}

#[test]
fn damaged_swapped_and_doubled_chunks_are_baked_again_to_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let bakes = |name: &str| BakeJob { chunks: Some(4), ..indirect_job(folder.path(), name, BakeParts::ALL) };
    bake(interior(), &bakes("whole.cuts"), &Silent).unwrap();
    let whole = std::fs::read(folder.path().join("whole.cuts")).unwrap();
    let job = bakes("a.cuts");
    let partial = Checkpoint::folder_of(&job.output);
    let file = |name: &str| partial.join(name);
    let copy = |from: &str, to: &str| assert!(std::fs::copy(file(from), file(to)).unwrap() > 0);
    let changes: [&dyn Fn(); 4] = [
        &|| {
            let mut bytes = std::fs::read(file("chunk-00001.bin")).unwrap();
            bytes[120] ^= 4;
            std::fs::write(file("chunk-00001.bin"), bytes).unwrap();
        },
        &|| copy("chunk-00002.bin", "chunk-00001.bin"),
        &|| {
            std::fs::rename(file("chunk-00000.bin"), file("chunk-00009.bin")).unwrap();
            std::fs::rename(file("source-chunk-00000.bin"), file("chunk-00000.bin")).unwrap();
        },
        &|| copy("source-chunk-00000.bin", "source-environment-chunk-00000.bin"),
    ];
    for (i, change) in changes.into_iter().enumerate() {
        assert!(matches!(bake(interior(), &job, &CancelIn::phase(Phase::Transport)), Err(BakeError::Cancelled)));
        change();
        bake(interior(), &BakeJob { resume: true, ..job.clone() }, &Silent).unwrap();
        assert!(std::fs::read(&job.output).unwrap() == whole, "change {i}");
        std::fs::remove_file(&job.output).unwrap();
    }
}

#[test]
fn a_second_bake_of_an_output_is_refused_while_the_first_runs() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "a.cuts");
    let held = OutputLock::acquire(&job.output).unwrap();
    assert!(matches!(bake(scene(), &job, &Silent), Err(BakeError::Lock(LockError::Held { .. }))));
    assert!(!Checkpoint::folder_of(&job.output).exists(), "nothing is touched");
    drop(held);
    assert!(bake(scene(), &job, &Silent).is_ok(), "negative control");
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["a.cuts"], "neither checkpoint nor lock");
}

/// Removes a chunk before it is packed.
struct Robber(PathBuf);

impl Observer for Robber {
    fn event(&self, event: Event) {
        if matches!(event, Event::Started { phase: Phase::Pack, .. }) {
            std::fs::remove_file(&self.0).unwrap();
        }
    }
}

#[test]
fn a_chunk_that_is_taken_away_before_it_is_packed_is_told_and_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(3), ..job(folder.path(), "a.cuts") };
    let taken = Checkpoint::folder_of(&job.output).join("chunk-00001.bin");
    let told = bake(scene(), &job, &Robber(taken.clone())).unwrap_err();
    assert!(matches!(&told, BakeError::Checkpoint(CheckpointError::Lost { path }) if *path == taken), "{told}");
    assert!(!job.output.exists(), "no half dataset");
    let resumed = bake(scene(), &BakeJob { resume: true, ..job.clone() }, &Silent).unwrap();
    let whole = bake(scene(), &BakeJob { output: folder.path().join("b.cuts"), ..job }, &Silent).unwrap();
    assert_eq!(contents(&resumed), contents(&whole));
}

#[test]
fn chunks_of_vertices_that_lay_elsewhere_are_baked_again() {
    let folder = tempfile::tempdir().unwrap();
    let whole = bake(scene(), &job(folder.path(), "whole.cuts"), &Silent).unwrap();
    let points = bake_points(&whole);
    // A ray is added to the first chunk, which is kept for vertices at these coordinates.
    let rays_with_chunk_for = |coordinates: &[f32]| {
        let job = interrupted(folder.path());
        let content = Content::still(&whole.scene_hash);
        let checkpoint = Checkpoint::open(&job.output, &Work::All, &content, &job.settings).unwrap().unwrap();
        let kept = |coordinates: &[f32]| checkpoint.series(Series::Environment, Places::of(&[], coordinates));
        let known = kept(&points.coordinates());
        let length = known.range(points.points.len(), 0).len();
        let mut chunk = known.load(0, length, whole.tree.height()).unwrap();
        chunk.rays += 1;
        kept(coordinates).store(0, &chunk).unwrap();
        let told = Told::default();
        let rays = bake(scene(), &BakeJob { resume: true, ..job }, &told).unwrap().report.rays_traced;
        (rays, told.all().join("\n").contains("other bake points"))
    };
    let mut elsewhere = points.coordinates();
    elsewhere[0] += 0.1;
    assert_eq!(rays_with_chunk_for(&elsewhere), (whole.report.rays_traced, true));
    let known = (whole.report.rays_traced + 1, false);
    assert_eq!(rays_with_chunk_for(&points.coordinates()), known, "negative control");
}
