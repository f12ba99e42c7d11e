//! Bakes of scenes with objects moved from their place in the file.

use super::*;
use crate::{
    errors::{CheckpointError, ShardError},
    shard::Shard,
};
use lapidary_core::{
    animation::{BoundAnimation, ClipTime},
    scene::{
        Mesh, Object,
        pose::{DeformedObject, Objects, Pose, PosedVertices, Poses},
    },
};
use lapidary_interchange::{
    animation, image,
    import::{ImportOptions, import},
};

/// A floor and a block as a separate object.
fn of_two() -> Scene {
    let mut scene = scene();
    scene.mesh.triangle_object[2..].fill(1);
    scene.objects.push(Object { name: "block".into() });
    scene
}

fn raised(x: f32) -> Poses {
    let mut poses = Poses::default();
    poses.set(
        1,
        Pose { translate: Vec3::new(x, 0.3, 0.0), rotate_degrees: Vec3::Y * 30.0, scale: 1.2, ..Pose::AS_BAKED },
    );
    poses
}

#[test]
fn a_posed_scene_is_baked_as_one_whose_file_is_so_and_keeps_its_file_and_its_poses() {
    let folder = tempfile::tempdir().unwrap();
    let baked = |scene: Scene, poses: Poses, name: &str| {
        bake(scene, &BakeJob { poses, ..job(folder.path(), name) }, &Silent).unwrap()
    };
    let posed = baked(of_two(), raised(0.5), "posed.cuts");
    let mut so_in_its_file = of_two();
    so_in_its_file.mesh = raised(0.5).pose(&of_two().mesh, &Objects::of(&of_two())).unwrap();
    let expected = baked(so_in_its_file, Poses::default(), "file.cuts");
    assert_eq!(contents(&posed), contents(&expected));
    assert_ne!(contents(&baked(of_two(), Poses::default(), "as.cuts")), contents(&expected), "negative control");
    assert_eq!(posed.scene_hash, scene_hash(&of_two()));
    let read = Dataset::read(&folder.path().join("posed.cuts"), image::decode).unwrap();
    assert_eq!((read.scene.placed_poses(), &read.scene.placed), (raised(0.5), &posed.scene.placed));
    assert!(read.scene.poses_since_baked(&raised(0.5)).is_empty());
    assert_eq!(expected.scene.placed, []);
}

#[test]
fn a_bake_that_hides_an_object_keeps_it_in_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let baked =
        |poses: Poses, name: &str| bake(of_two(), &BakeJob { poses, ..job(folder.path(), name) }, &Silent).unwrap();
    let mut hidden = raised(0.5);
    hidden.set(1, Pose { hidden: true, ..hidden.of(1) });
    let (whole, gone) = (baked(raised(0.5), "whole.cuts"), baked(hidden.clone(), "gone.cuts"));
    let mut scene = whole.scene.clone();
    scene.place_again(&hidden).unwrap();
    let updated = update::update(&whole, scene, &Silent).unwrap();
    assert!(gone.scene.mesh == updated.scene.mesh);
    assert_eq!(contents(&gone), contents(&updated));
    assert_ne!(contents(&gone), contents(&whole), "negative control");
    let read = Dataset::read(&folder.path().join("gone.cuts"), image::decode).unwrap();
    assert!(read.scene.placed_poses() == hidden && read.scene.hidden == gone.scene.hidden);
    assert_eq!(*read.scene.shown_mesh(), whole.scene.mesh);
    assert!(contents(&whole) != contents(&gone) && contents(&read) == contents(&gone));

    // The positions of another number of vertices.
    let mut damaged = read;
    let path = folder.path().join("damaged.cuts");
    damaged.scene.hidden.clear();
    damaged.write(&path).unwrap();
    let refused = Dataset::read(&path, image::decode).unwrap_err().to_string();
    assert!(refused.contains("hidden_positions") && refused.contains("damaged.cuts"), "{refused}");
}

#[test]
fn a_bake_goes_on_only_with_the_poses_that_it_began_with() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(5), poses: raised(0.5), ..job(folder.path(), "a.cuts") };
    assert!(bake(of_two(), &job, &CancelIn::phase(Phase::Visibility)).is_err());
    let other = BakeJob { resume: true, poses: raised(0.6), ..job.clone() };
    let refused = bake(of_two(), &other, &Silent).unwrap_err();
    assert!(matches!(refused, BakeError::Checkpoint(_)), "{refused}");
    assert!(bake(of_two(), &BakeJob { resume: true, ..job.clone() }, &Silent).is_ok());
    let mut far = Poses::default();
    far.set(1, Pose { translate: Vec3::X * 1e30, ..Pose::AS_BAKED });
    let out_of_reach = bake(of_two(), &BakeJob { poses: far, ..job }, &Silent).unwrap_err();
    assert!(out_of_reach.to_string().contains("cannot be posed"), "{out_of_reach}");
}

/// The block posed by an animation's keyframes.
fn slid(x: f32) -> Poses {
    let (mesh, objects) = (of_two().mesh, Objects::of(&of_two()));
    let block = || objects.vertices(1).iter().map(|&vertex| vertex as usize);
    let vertices = PosedVertices {
        positions: block().map(|vertex| mesh.positions[vertex] + Vec3::X * x).collect(),
        normals: block().map(|vertex| mesh.normals[vertex]).collect(),
        tangents: block().map(|vertex| mesh.tangents[vertex]).collect(),
    };
    let mut poses = Poses::default();
    poses.deform(1, Some(DeformedObject::new(vertices, [0, 0, 1])));
    poses
}

/// At one time of a clip that slides the block by `x`.
fn sliding(x: f32, job: BakeJob) -> BakeJob {
    BakeJob { poses: slid(x), clip_time: Some(ClipTime { clip: "slide".into(), seconds: 0.5 }), ..job }
}

#[test]
fn chunks_of_other_keyframes_are_not_mixed() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(5), ..job(folder.path(), "a.cuts") };
    assert!(bake(of_two(), &sliding(0.5, job.clone()), &CancelIn::phase(Phase::Visibility)).is_err());
    let resume = |x| bake(of_two(), &BakeJob { resume: true, ..sliding(x, job.clone()) }, &Silent);
    let refused = resume(0.6).unwrap_err();
    assert!(matches!(refused, BakeError::Checkpoint(CheckpointError::Mismatch { .. })), "{refused}");
    assert!(resume(0.5).is_ok(), "negative control");
    let share = |index, x| {
        let shard = Shard::new(index, 2).unwrap();
        bake_shard(of_two(), &sliding(x, job.clone()), shard, None, &Silent).unwrap();
    };
    share(1, 0.5);
    share(2, 0.6);
    let refused = merge(&job.output, image::decode, &Silent).unwrap_err();
    assert!(matches!(refused, BakeError::Shard(ShardError::OfAnother { .. })), "{refused}");
    std::fs::remove_dir_all(Shard::new(2, 2).unwrap().folder_of(&job.output)).unwrap();
    share(2, 0.5);
    let merged = merge(&job.output, image::decode, &Silent).unwrap();
    assert_eq!(contents(&merged), contents(&bake(of_two(), &sliding(0.5, job), &Silent).unwrap()));
}

#[test]
fn an_object_that_was_baked_in_an_animation_is_shown_where_the_next_bake_has_it() {
    const TOWER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/bending-tower/bending-tower.gltf");
    let (folder, scene) = (tempfile::tempdir().unwrap(), import(Path::new(TOWER)).unwrap().scene);
    let bound = |scene: &Scene| {
        BoundAnimation::new(animation::read(Path::new(TOWER), &ImportOptions::default()).unwrap(), scene).unwrap()
    };
    let clip = bound(&scene).animation().clip(Some("Block")).unwrap();
    let block = scene.objects.iter().position(|object| object.name == "Block").unwrap() as u32;
    let baked = |seconds: f32, poses: &Poses| {
        let job = with(job(folder.path(), "a.cuts"), |settings| settings.max_vertices = None);
        let poses = bound(&scene).poses_at(clip, seconds, poses).unwrap();
        let clip_time = Some(ClipTime { clip: "Block".into(), seconds });
        bake(scene.clone(), &BakeJob { poses, clip_time, ..job }, &Silent).unwrap().scene
    };
    let before = baked(1.0, &Poses::default());
    let mut turned = Poses::default();
    turned.set(block, Pose { rotate_degrees: Vec3::Y * 90.0, ..Pose::AS_BAKED });
    let shown = |seconds: f32, poses: &Poses| {
        let since = bound(&before).poses_at(clip, seconds, &before.poses_since_baked(poses)).unwrap();
        since.pose(&before.mesh, &Objects::of(&before)).unwrap()
    };
    let apart =
        |a: &Mesh, b: &Mesh| a.positions.iter().zip(&b.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    for seconds in [1.0, 0.4] {
        let again = baked(seconds, &turned).mesh;
        assert!(apart(&shown(seconds, &turned), &again) < 1e-4, "{seconds} s");
        assert!(apart(&shown(seconds, &Poses::default()), &again) > 0.1, "negative control: not turned");
    }
    let mut hidden = turned.clone();
    hidden.set(block, Pose { hidden: true, ..turned.of(block) });
    let gone = baked(1.0, &hidden);
    for seconds in [1.0, 0.4] {
        let seen = |poses: &Poses| {
            let since = bound(&gone).poses_at(clip, seconds, &gone.poses_since_baked(poses)).unwrap();
            since.pose(&gone.mesh, &Objects::of(&gone)).unwrap()
        };
        let expected = baked(seconds, &turned).mesh;
        assert!(apart(&seen(&turned), &expected) < 1e-4, "shown again at {seconds} s");
        assert!(apart(&seen(&hidden), &expected) > 0.1, "negative control: still hidden");
    }
    let about_its_box = turned.pose(&before.mesh, &Objects::of(&before)).unwrap();
    assert!(apart(&about_its_box, &baked(1.0, &turned).mesh) > 0.1, "negative control: another center");
}
