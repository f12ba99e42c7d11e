//! Bakes of scenes whose objects are not where their file has them.

use super::*;
use lapidary_core::scene::{
    Object,
    pose::{Objects, Pose, Poses},
};

/// A floor and a block, an object of its own.
fn of_two() -> Scene {
    let mut scene = scene();
    scene.mesh.triangle_object[2..].fill(1);
    scene.objects.push(Object { name: "block".into() });
    scene
}

fn raised(x: f32) -> Poses {
    let mut poses = Poses::default();
    poses.set(1, Pose { translate: Vec3::new(x, 0.3, 0.0), rotate_degrees: Vec3::Y * 30.0, scale: 1.2 });
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
    let read = Dataset::read(&folder.path().join("posed.cuts")).unwrap();
    assert_eq!((read.scene.placed_poses(), &read.scene.placed), (raised(0.5), &posed.scene.placed));
    assert!(read.scene.poses_since_baked(&raised(0.5)).is_empty());
    assert_eq!(expected.scene.placed, []);
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
