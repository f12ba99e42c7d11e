//! Poses of objects and pose files.

use super::*;
use crate::{
    ground::add_ground,
    ray::Intersector,
    scene::Scene,
    sphere::fibonacci_directions,
    test_scenes::{cubes, dataset},
};
use std::path::Path;

fn posed(scene: &Scene, object: u32, pose: Pose) -> Mesh {
    let mut poses = Poses::default();
    poses.set(object, pose);
    poses.pose(&scene.mesh, &Objects::of(scene)).unwrap()
}

#[test]
fn an_object_turns_about_its_centre_in_the_order_x_y_z_and_then_moves() {
    let scene = cubes(3);
    let objects = Objects::of(&scene);
    let pose = Pose {
        translate: Vec3::new(1.0, 2.0, 3.0),
        rotate_degrees: Vec3::new(90.0, 90.0, 0.0),
        scale: 2.0,
        ..Pose::AS_BAKED
    };
    let mesh = posed(&scene, 1, pose);
    let center = objects.center(1);
    for v in objects.vertices(1).iter().map(|&v| v as usize) {
        // About X, y becomes z; then about Y, z becomes x, and x becomes -z.
        let turned = |Vec3 { x, y, z }: Vec3| Vec3::new(y, -z, -x);
        let expected = center + 2.0 * turned(scene.mesh.positions[v] - center) + pose.translate;
        assert!((mesh.positions[v] - expected).length() < 1e-5);
        assert!((mesh.normals[v] - turned(scene.mesh.normals[v])).length() < 1e-5);
        let tangent = turned(scene.mesh.tangents[v].truncate()).extend(scene.mesh.tangents[v].w);
        assert!((mesh.tangents[v] - tangent).length() < 1e-5);
    }
    let others = |mesh: &Mesh| {
        [0, 2].map(|o| objects.vertices(o).iter().map(|&v| mesh.positions[v as usize]).collect::<Vec<_>>())
    };
    assert_eq!(others(&mesh), others(&scene.mesh));
    assert!(mesh.validate(1, 3).is_ok() && mesh.triangles == scene.mesh.triangles);
}

#[test]
fn no_ray_meets_a_hidden_object_and_all_others_stay() {
    let scene = cubes(3);
    let objects = Objects::of(&scene);
    let mesh = posed(&scene, 1, Pose { translate: Vec3::X, hidden: true, ..Pose::AS_BAKED });
    let is_of_object = |v: usize| objects.vertices(1).contains(&(v as u32));
    for (v, (now, before)) in mesh.positions.iter().zip(&scene.mesh.positions).enumerate() {
        assert_eq!(*now, if is_of_object(v) { objects.center(1) + Vec3::X } else { *before });
    }
    assert!(mesh.normals == scene.mesh.normals && mesh.validate(1, 3).is_ok());
    let met = |mesh: &Mesh| {
        let rays = Intersector::new(mesh);
        let of_object = |&d: &Vec3| {
            let hit = rays.closest_hit(objects.center(1) - 3.0 * d, d);
            hit.is_some_and(|hit| mesh.triangle_object[hit.triangle as usize] == 1)
        };
        fibonacci_directions(500).iter().filter(|d| of_object(d)).count()
    };
    assert!(met(&mesh) == 0 && met(&scene.mesh) > 100, "negative control: it is shown");
}

#[test]
fn a_scene_as_baked_is_the_same_to_the_bit() {
    let scene = cubes(2);
    assert_eq!(posed(&scene, 0, Pose::AS_BAKED), scene.mesh);
    let mut poses = Poses::default();
    poses.set(1, Pose { scale: 2.0, ..Pose::AS_BAKED });
    assert_eq!(poses.moved().collect::<Vec<_>>(), [1]);
    assert_ne!(poses.pose(&scene.mesh, &Objects::of(&scene)).unwrap(), scene.mesh, "negative control");
    poses.set(1, Pose::AS_BAKED);
    assert!(poses.is_empty());
}

#[test]
fn turns_survive_their_degrees() {
    for (x, y, z) in [(0.3, -0.7, 2.0), (1.0, 1.5, -0.2), (0.0, 0.5, 0.0)] {
        let rotation = Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
        let again = Pose::AS_BAKED.with_rotation(rotation).rotation();
        assert!(rotation.angle_between(again) < 1e-3);
        assert!(rotation.angle_between(Pose::AS_BAKED.rotation()) > 0.1, "negative control");
    }
}

#[test]
fn a_turn_about_a_hinge_is_read_back_beside_any_other_turn() {
    let hinge = Vec3::new(0.6, 0.0, -0.8);
    for other in [Vec3::ZERO, Vec3::new(20.0, -50.0, 10.0)] {
        let closed = Pose { rotate_degrees: other, translate: Vec3::Y, ..Pose::AS_BAKED };
        let before = closed.degrees_about(hinge);
        for degrees in [-120.0, 35.0, 95.0] {
            let open = closed.turned_about(hinge, degrees);
            let read = open.degrees_about(hinge) - before;
            assert!(
                (read - degrees).rem_euclid(360.0).min((degrees - read).rem_euclid(360.0)) < 0.05,
                "{other}: {read}"
            );
            let still = (open.rotation() * hinge).distance(closed.rotation() * hinge);
            assert!(still < 1e-4 && open.translate == closed.translate, "the hinge stays: {still}");
        }
    }
    assert!(Pose::AS_BAKED.turned_about(Vec3::Y, 40.0).degrees_about(Vec3::X).abs() < 1e-3, "negative control");
}

#[test]
fn an_object_beyond_reach_is_refused() {
    let scene = cubes(1);
    let mut poses = Poses::default();
    poses.set(0, Pose { translate: Vec3::splat(9e8), scale: MOST_SCALE, ..Pose::AS_BAKED });
    assert!(poses.pose(&scene.mesh, &Objects::of(&scene)).is_ok());
    poses.set(0, Pose { translate: Vec3::splat(1e9), scale: MOST_SCALE, ..Pose::AS_BAKED });
    assert!(matches!(poses.pose(&scene.mesh, &Objects::of(&scene)), Err(MeshError::TooFar { .. })));
}

#[test]
fn an_object_without_triangles_is_posed_as_nothing() {
    let mut scene = cubes(2);
    scene.objects.push(crate::scene::Object { name: "empty".into() });
    assert!(Objects::of(&scene).vertices(2).is_empty());
    assert_eq!(posed(&scene, 2, Pose { scale: 2.0, ..Pose::AS_BAKED }), scene.mesh);
}

fn read(text: &str, scene: &Scene) -> Result<Poses, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("poses.json");
    std::fs::write(&path, text).unwrap();
    let read = Poses::read(&path, scene).map_err(|error| error.to_string());
    assert!(read.as_ref().err().is_none_or(|error| error.contains("poses.json")), "{read:?}");
    read
}

#[test]
fn a_file_poses_objects_by_name_and_says_what_is_wrong() {
    let mut scene = cubes(3);
    scene.objects[2].name = "cube 1".into();
    let text = r#"{"objects": {"cube 1": {"translate": [0, 1, 0], "rotate_degrees": [0, 45, 0]}, "cube 0": {"scale": 0.5, "hidden": true}}}"#;
    let poses = read(text, &scene).unwrap();
    let turned = Pose { translate: Vec3::Y, rotate_degrees: Vec3::new(0.0, 45.0, 0.0), scale: 1.0, ..Pose::AS_BAKED };
    let expected = [Pose { scale: 0.5, hidden: true, ..Pose::AS_BAKED }, turned, turned];
    assert_eq!([0, 1, 2].map(|o| poses.of(o)), expected);
    let marked = read(&format!("\u{feff}{text}"), &scene).unwrap();
    assert_eq!([0, 1, 2].map(|o| marked.of(o)), expected, "with a byte order mark");
    add_ground(&mut scene);
    for (text, said) in [
        (r#"{"objects": {"cub": {}}}"#, "no object \"cub\"; it has cube 0, cube 1"),
        (r#"{"objects": {"cube 0": {"scale": 0}}}"#, "scale of \"cube 0\" is 0; it must be above 0"),
        (r#"{"objects": {"cube 0": {"scale": -1}}}"#, "must be above 0"),
        (r#"{"objects": {"cube 0": {"translate": [2e9, 0, 0]}}}"#, "out of reach"),
        (r#"{"objects": {"cube 0": {"translate": [1e60, 0, 0]}}}"#, "line 1"),
        (r#"{"objects": {"cube 0": {"turn": 3}}}"#, "unknown field `turn`"),
        (r#"{"objects": {"Ground": {"scale": 2}}}"#, "the ground cannot be posed"),
        ("[]", "write them as"),
    ] {
        let refused = read(text, &scene).unwrap_err();
        assert!(refused.contains(said), "{refused}");
    }
    assert!(Poses::read(Path::new("/none.json"), &scene).unwrap_err().to_string().contains("/none.json"));
    let many = dataset(&["a"], &[]).scene;
    assert!(read(r#"{"objects": {"x": {}}}"#, &many).unwrap_err().contains("it has o"));
}
