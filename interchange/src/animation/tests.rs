//! Animations of files that the tests write, against known answers.

mod bad_input;
mod channels;
mod damage;
mod file;
mod hidden;
mod sheets;

use super::AnimationFileError;
use crate::{
    animation,
    import::{ImportOptions, import},
};
use file::TestFile;
use glam::{Mat4, Quat, Vec3};
use lapidary_core::{
    animation::{Animation, BoundAnimation, ClipTime, Playback, clip},
    ray::{Intersector, Posable},
    scene::{
        Mesh, Scene,
        pose::{Objects, Pose, Poses},
    },
    sphere::fibonacci_directions,
};
use serde_json::json;
use std::{
    f32::consts::FRAC_PI_2,
    path::{Path, PathBuf},
};

/// Heights of the rings of the bar.
const HEIGHTS: [f32; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];

const RIGHT_ANGLE: [f32; 4] = [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];
const NO_TURN: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// An upright bar of height 2 with two joints at heights 0 and 1; the middle ring follows both. The node of its mesh is elsewhere.
fn bar(upper: [f32; 4]) -> TestFile {
    let nodes = json!([
        { "name": "bar", "mesh": 0, "skin": 0, "translation": [7, 8, 9] },
        { "name": "lower", "children": [2] },
        { "name": "upper", "translation": [0, 1, 0], "rotation": upper },
    ]);
    let mut file = TestFile::new(nodes, 2);
    let corners = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]];
    let ring = |y: f32| corners.into_iter().flat_map(move |[x, z]| [x, y, z]);
    let positions: Vec<f32> = HEIGHTS.into_iter().flat_map(ring).collect();
    let side = |ring: u16, k: u16| {
        let [a, b] = [4 * ring + k, 4 * ring + (k + 1) % 4];
        [a, a + 4, b, b, a + 4, b + 4]
    };
    let mut indices: Vec<u16> = (0..4).flat_map(|ring| (0..4).flat_map(move |k| side(ring, k))).collect();
    indices.extend([0, 1, 2, 0, 2, 3, 16, 18, 17, 16, 19, 18]);
    let joints = file.shorts(&[0, 1, 0, 0].repeat(20), "VEC4");
    let of_ring = |y: f32| {
        if y < 1.0 {
            [2.0, 0.0]
        } else if y > 1.0 {
            [0.0, 2.0]
        } else {
            [1.0, 1.0]
        }
    };
    let weights: Vec<f32> = HEIGHTS.iter().flat_map(|&y| [of_ring(y)[0], of_ring(y)[1], 0.0, 0.0].repeat(4)).collect();
    let weights = file.floats(&weights, "VEC4");
    file.mesh(&positions, &indices, &[("JOINTS_0", joints), ("WEIGHTS_0", weights)]);
    file.skin(&[1, 2], &[[0.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    file
}

/// The bar with a clip that turns its upper joint by a right angle in two seconds.
fn bending_bar() -> TestFile {
    let mut file = bar(NO_TURN);
    file.clip("bend", 2, "rotation", &[0.0, 2.0], &[NO_TURN, RIGHT_ANGLE].concat(), "LINEAR");
    file
}

/// Position of a point of the bar with the upper joint turned by an angle about Z: the mean of both joints at the middle ring.
fn bent(p: Vec3, angle: f32) -> Vec3 {
    let turned = Vec3::Y + Quat::from_rotation_z(angle) * (p - Vec3::Y);
    if p.y < 0.99 {
        p
    } else if p.y > 1.01 {
        turned
    } else {
        0.5 * (p + turned)
    }
}

fn bound(file: &mut TestFile) -> (BoundAnimation, Scene) {
    let path = file.write();
    let scene = import(&path).unwrap().scene;
    let animation = animation::read(&path, &ImportOptions::default()).unwrap();
    assert_eq!(animation.warnings, [] as [String; 0]);
    (BoundAnimation::new(animation, &scene).unwrap(), scene)
}

fn posed(poses: &Poses, scene: &Scene) -> Mesh {
    let mesh = poses.pose(&scene.mesh, &Objects::of(scene)).unwrap();
    mesh.validate(scene.materials.len(), scene.objects.len()).unwrap();
    mesh
}

fn at(bound: &BoundAnimation, seconds: f32, scene: &Scene) -> Mesh {
    posed(&bound.poses_at(0, seconds, &Poses::default()).unwrap(), scene)
}

/// The largest distance between corresponding places; NaN if one of them is.
fn farthest(a: &[Vec3], b: impl IntoIterator<Item = Vec3>) -> f32 {
    let larger = |most: f32, distance: f32| if most > distance || most.is_nan() { most } else { distance };
    a.iter().zip(b).map(|(a, b)| a.distance(b)).fold(0.0, larger)
}

#[test]
fn a_bar_of_two_joints_bends_as_its_matrices_say() {
    let (bound, scene) = bound(&mut bending_bar());
    let baked = &scene.mesh.positions;
    assert_eq!((bound.clips()[0].name.as_str(), bound.clips()[0].seconds()), ("bend", 2.0));
    for (seconds, angle) in [(2.0, FRAC_PI_2), (1.0, 0.5 * FRAC_PI_2), (9.0, FRAC_PI_2), (-1.0, 0.0)] {
        let mesh = at(&bound, seconds, &scene);
        assert!(farthest(&mesh.positions, baked.iter().map(|&p| bent(p, angle))) < 1e-5, "{seconds} s");
    }
    let mesh = at(&bound, 2.0, &scene);
    assert!(farthest(&mesh.positions, baked.iter().map(|&p| bent(p, 1.4))) > 0.1, "negative control");
}

#[test]
fn normals_and_tangents_turn_with_the_surface() {
    let (bound, scene) = bound(&mut bending_bar());
    let (mesh, turn) = (at(&bound, 2.0, &scene), Quat::from_rotation_z(FRAC_PI_2));
    let upper = (0..mesh.positions.len()).filter(|&v| scene.mesh.positions[v].y > 1.6);
    for v in upper {
        assert!(mesh.normals[v].distance(turn * scene.mesh.normals[v]) < 1e-4);
        let (before, now) = (scene.mesh.tangents[v], mesh.tangents[v]);
        assert!(now.distance((turn * before.truncate()).extend(before.w)) < 1e-4);
        let is_side = scene.mesh.normals[v].x.abs() > 0.9;
        assert!(!is_side || mesh.normals[v].distance(scene.mesh.normals[v]) > 1.0, "negative control");
    }
    // Vertices that follow only the lower joint stay, to the bit, beside moving ones.
    let still = (0..mesh.positions.len()).filter(|&v| scene.mesh.positions[v].y < 0.1);
    assert!(still.clone().count() >= 8);
    still.for_each(|v| {
        assert_eq!((mesh.positions[v], mesh.tangents[v]), (scene.mesh.positions[v], scene.mesh.tangents[v]))
    });
}

#[test]
fn a_skin_at_rest_is_where_its_joints_rest_and_its_own_node_does_not_count() {
    let straight = import(&bar(NO_TURN).write()).unwrap();
    assert_eq!(straight.report.warnings, [] as [String; 0]);
    let bounds = straight.scene.mesh.bounds();
    assert!(bounds.min.distance(Vec3::new(-0.2, 0.0, -0.1)) < 1e-6, "not at 7, 8, 9: {bounds:?}");
    let resting = import(&bar(RIGHT_ANGLE).write()).unwrap().scene.mesh;
    let expected = bar_points().map(|p| bent(p, FRAC_PI_2));
    assert!(expected.clone().all(|e| resting.positions.iter().any(|p| p.distance(e) < 1e-5)));
    assert!(!bar_points().all(|e| resting.positions.iter().any(|p| p.distance(e) < 1e-5)), "negative control");
}

fn bar_points() -> impl Iterator<Item = Vec3> + Clone {
    HEIGHTS.into_iter().map(|y| Vec3::new(0.2, y, 0.1))
}

#[test]
fn at_rest_nothing_is_moved_and_near_it_almost_nothing() {
    let mut file = bar(RIGHT_ANGLE);
    file.clip("bend", 2, "rotation", &[0.0, 2.0], &[NO_TURN, RIGHT_ANGLE].concat(), "LINEAR");
    let spline = [[0.0; 4], RIGHT_ANGLE, [0.0; 4]].concat().repeat(2);
    file.clip("still", 2, "rotation", &[0.0, 1.0], &spline, "CUBICSPLINE");
    let (bound, scene) = bound(&mut file);
    assert!(bound.poses_at(0, 2.0, &Poses::default()).unwrap().is_empty());
    assert!(bound.poses_at(1, 0.37, &Poses::default()).unwrap().is_empty());
    let near = at(&bound, 1.999_999, &scene);
    assert!(farthest(&near.positions, scene.mesh.positions.iter().copied()) < 1e-5);
    assert!(
        farthest(&at(&bound, 1.9, &scene).positions, scene.mesh.positions.iter().copied()) > 0.05,
        "negative control"
    );
}

#[test]
fn nodes_carry_what_is_below_them() {
    let nodes = json!([
        { "name": "arm", "translation": [1, 0, 0], "rotation": RIGHT_ANGLE, "children": [1] },
        { "name": "hand", "translation": [0, 2, 0], "scale": [2, 1, 1], "children": [2, 3] },
        { "name": "thing", "mesh": 0, "translation": [0, 0, 3] },
        { "name": "lamp" },
        { "name": "floor", "mesh": 0 },
    ]);
    let mut file = TestFile::new(nodes, 1);
    file.json["scenes"][0]["nodes"] = json!([0, 4]);
    file.mesh(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.], &[0, 1, 2, 0, 2, 3], &[]);
    let turn = Quat::from_rotation_x(1.0);
    file.clip("turn", 1, "rotation", &[0.0, 1.0], &[NO_TURN, turn.to_array()].concat(), "LINEAR");
    file.clip("slide", 0, "translation", &[0.0, 1.0], &[1.0, 0.0, 0.0, 5.0, 6.0, 7.0], "STEP");
    file.clip("grow", 2, "scale", &[0.0, 1.0], &[1.0, 1.0, 1.0, 3.0, 3.0, 0.0], "LINEAR");
    let (bound, scene) = bound(&mut file);
    assert_eq!(bound.objects().collect::<Vec<_>>(), [0], "the floor does not move");
    let arm = Mat4::from_rotation_translation(Quat::from_array(RIGHT_ANGLE), Vec3::X);
    let hand = |turn| Mat4::from_scale_rotation_translation(Vec3::new(2.0, 1.0, 1.0), turn, 2.0 * Vec3::Y);
    let thing = Mat4::from_translation(3.0 * Vec3::Z);
    let grown = thing * Mat4::from_scale(Vec3::new(3.0, 3.0, clip::LEAST_SCALE));
    let slid = Mat4::from_rotation_translation(Quat::from_array(RIGHT_ANGLE), Vec3::new(5.0, 6.0, 7.0));
    let rest = arm * hand(Quat::IDENTITY) * thing;
    let of_thing = Objects::of(&scene).vertices(0).to_vec();
    let places = |mesh: &Mesh| of_thing.iter().map(|&v| mesh.positions[v as usize]).collect::<Vec<_>>();
    for (clip, expected) in
        [arm * hand(turn) * thing, slid * hand(Quat::IDENTITY) * thing, arm * hand(Quat::IDENTITY) * grown]
            .into_iter()
            .enumerate()
    {
        let mesh = posed(&bound.poses_at(clip, 1.0, &Poses::default()).unwrap(), &scene);
        let own = places(&scene.mesh).into_iter().map(|p| rest.inverse().transform_point3(p)).collect::<Vec<_>>();
        assert!(farthest(&places(&mesh), own.iter().map(|p| expected.transform_point3(*p))) < 1e-5, "clip {clip}");
        assert!(farthest(&places(&mesh), own.iter().map(|p| rest.transform_point3(*p))) > 0.5, "negative control");
    }
    assert!(bound.poses_at(1, 0.99, &Poses::default()).unwrap().is_empty(), "a step stays until its time");
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let mut file = TestFile::new(json!([{ "name": "flag", "mesh": 0, "weights": [0.5, 0.0] }]), 1);
    let normals = file.floats(&[0.0, 0.0, 1.0].repeat(4), "VEC3");
    let square = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    file.mesh(&square, &[0, 1, 2, 0, 2, 3], &[("NORMAL", normals)]);
    let raised = file.floats(&[0., 0., 0., 0., 0., 1., 0., 0., 1., 0., 0., 0.], "VEC3");
    let tilted = file.floats(&[-1.0, 0.0, 0.0].repeat(4), "VEC3");
    let longer = file.floats(&[0., 0., 0., 2., 0., 0., 2., 0., 0., 0., 0., 0.], "VEC3");
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": raised, "NORMAL": tilted }, { "POSITION": longer }]);
    file.clip("wave", 0, "weights", &[0.0, 1.0], &[0.5, 0.0, 1.0, 0.25], "LINEAR");
    let (bound, scene) = bound(&mut file);
    let shape = |raise: f32, lengthen: f32| move |p: &Vec3| Vec3::new(p.x * (1.0 + 2.0 * lengthen), p.y, p.x * raise);
    // At rest the first target has weight one half.
    let expected = |of: &dyn Fn(&Vec3) -> Vec3| scene.mesh.positions.iter().map(of).collect::<Vec<_>>();
    assert!(scene.mesh.positions.iter().all(|p| (p.z - 0.5 * p.x).abs() < 1e-6));
    let normal = Vec3::new(-0.5, 0.0, 1.0).normalize();
    assert!(scene.mesh.normals.iter().all(|n| n.distance(normal) < 1e-6));
    for (seconds, raise, lengthen) in [(1.0, 1.0, 0.25), (0.5, 0.75, 0.125)] {
        let mesh = at(&bound, seconds, &scene);
        assert!(farthest(&mesh.positions, expected(&shape(raise, lengthen))) < 1e-6);
        assert!(farthest(&mesh.positions, expected(&shape(raise, 0.0))) > 0.1, "negative control");
        let normal = Vec3::new(-raise, 0.0, 1.0).normalize();
        assert!(mesh.normals.iter().all(|n| n.distance(normal) < 1e-5));
    }
}

/// The mesh with every triangle cut in four.
fn tessellated(scene: &Scene) -> Scene {
    let mut fine = scene.clone();
    let mesh = &mut fine.mesh;
    for (t, [a, b, c]) in std::mem::take(&mut mesh.triangles).into_iter().enumerate() {
        let mut middle = |a: u32, b: u32| {
            let [a, b] = [a as usize, b as usize];
            mesh.positions.push(0.5 * (mesh.positions[a] + mesh.positions[b]));
            mesh.normals.push((mesh.normals[a] + mesh.normals[b]).normalize());
            mesh.tangents.push(mesh.tangents[a]);
            mesh.uvs.push(0.5 * (mesh.uvs[a] + mesh.uvs[b]));
            mesh.positions.len() as u32 - 1
        };
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        mesh.triangles.extend([[a, ab, ca], [ab, b, bc], [bc, c, ca], [ab, bc, ca]]);
        mesh.triangle_object.splice(4 * t..=4 * t, [scene.mesh.triangle_object[t]; 4]);
        mesh.triangle_material.splice(4 * t..=4 * t, [scene.mesh.triangle_material[t]; 4]);
    }
    fine
}

#[test]
fn a_tessellated_mesh_moves_as_the_triangles_that_it_was_cut_from() {
    let mut file = bending_bar();
    let path = file.write();
    let scene = import(&path).unwrap().scene;
    let fine = tessellated(&tessellated(&scene));
    let read = || animation::read(&path, &ImportOptions::default()).unwrap();
    let coarse = at(&BoundAnimation::new(read(), &scene).unwrap(), 1.5, &scene);
    let bound = at(&BoundAnimation::new(read(), &fine).unwrap(), 1.5, &fine);
    let exact = tessellated(&tessellated(&Scene { mesh: coarse, ..scene.clone() })).mesh;
    assert_eq!(bound.triangles, exact.triangles);
    assert!(farthest(&bound.positions, exact.positions.iter().copied()) < 1e-5);
    assert!(farthest(&fine.mesh.positions, exact.positions.iter().copied()) > 0.5, "negative control");
}

#[test]
fn rays_meet_a_deformed_object_as_if_it_had_been_built_so() {
    let (bound, scene) = bound(&mut bending_bar());
    let baked = Intersector::of_scene(&scene);
    let poses = bound.poses_at(0, 1.3, &Poses::default()).unwrap();
    let mesh = posed(&poses, &scene);
    let moving = poses.moved().collect();
    let deformed = Posable::new(&baked, &scene, &moving).posed(&mesh);
    let met = |rays: &Intersector| {
        let hit = |&d: &Vec3| {
            rays.closest_hit(Vec3::new(-1.0, 1.0, 0.9), d).map(|hit| (hit.triangle, hit.distance.to_bits()))
        };
        fibonacci_directions(5000).iter().map(hit).collect::<Vec<_>>()
    };
    let expected = met(&Intersector::new(&mesh));
    assert!(expected.iter().flatten().count() > 50);
    assert_eq!(met(&deformed), expected);
    assert_ne!(met(&baked), expected, "negative control");
}

#[test]
fn a_rigid_pose_comes_on_top_about_the_centre_as_baked() {
    let (bound, scene) = bound(&mut bending_bar());
    let pose =
        Pose { translate: Vec3::new(1.0, 0.0, 2.0), rotate_degrees: Vec3::Y * 90.0, scale: 2.0, ..Pose::AS_BAKED };
    let mut poses = Poses::default();
    poses.set(0, pose);
    let both = bound.poses_at(0, 2.0, &poses).unwrap();
    assert_eq!((both.of(0), both.moved().collect::<Vec<_>>()), (pose, vec![0]));
    let world_from_baked = pose.world_from_baked(Objects::of(&scene).center(0));
    let expected = |of: &Mesh| of.positions.iter().map(|&p| world_from_baked.transform_point3(p)).collect::<Vec<_>>();
    let mesh = posed(&both, &scene);
    assert!(farthest(&mesh.positions, expected(&at(&bound, 2.0, &scene))) < 1e-5);
    assert!(farthest(&mesh.positions, expected(&scene.mesh)) > 0.5, "negative control");
    assert_eq!(bound.poses_at(0, 0.0, &both).unwrap(), poses, "the deformation of another time goes");
}

#[test]
fn poses_of_one_time_are_equal_and_those_of_others_differ() {
    let (bound, scene) = bound(&mut bending_bar());
    let none = Poses::default();
    let [a, b, c] = [1.0, 1.0, 1.5].map(|seconds| bound.poses_at(0, seconds, &none).unwrap());
    assert!(a == b && a != c && a != none && !a.is_empty() && !a.is_as_baked(0));
    assert_eq!(a.differing(&b).count(), 0);
    assert_eq!(a.differing(&c).collect::<Vec<_>>(), [0]);
    assert_eq!(bound.poses_at(0, 5.0, &none).unwrap(), bound.poses_at(0, 2.0, &none).unwrap());
    let elsewhere = a.renumbered(|object| Some(object + 1));
    assert_eq!((elsewhere.deformed(1), elsewhere.deformed(0)), (a.deformed(0), None));
    let (other, _) = self::bound(&mut bending_bar());
    assert_ne!(other.poses_at(0, 1.0, &none).unwrap(), a, "of another file");
    let cut = Scene { mesh: tessellated(&scene).mesh, ..scene };
    let refused = a.pose(&cut.mesh, &Objects::of(&cut)).unwrap_err().to_string();
    assert!(refused.contains("object 0 is deformed with"), "{refused}");
}

#[test]
fn a_mirrored_skeleton_keeps_the_outside_out() {
    let mut file = bar(NO_TURN);
    file.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let mesh = import(&file.write()).unwrap().scene.mesh;
    let center = mesh.bounds().center();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        assert!(mesh.area_vector(t).dot((a + b + c) / 3.0 - center) > 0.0);
    }
}

#[test]
fn ten_thousand_objects_of_which_one_moves_are_read_bound_and_posed_at_once() {
    let node = |k: usize| json!({ "name": format!("n{k}"), "mesh": 0, "translation": [k, 0, 0] });
    let mut file = TestFile::new((0..10_000).map(node).collect(), 10_000);
    file.mesh(&[0., 0., 0., 1., 0., 0., 1., 1., 0.], &[0, 1, 2], &[]);
    file.clip("up", 77, "translation", &[0.0, 1.0], &[77.0, 0.0, 0.0, 77.0, 5.0, 0.0], "LINEAR");
    let start = std::time::Instant::now();
    let (bound, scene) = bound(&mut file);
    let mesh = at(&bound, 1.0, &scene);
    assert_eq!(bound.objects().collect::<Vec<_>>(), [77]);
    let raised = (0..mesh.positions.len()).filter(|&v| mesh.positions[v].y > 2.0).count();
    assert_eq!(raised, 3);
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}

#[test]
fn a_clip_may_be_played_in_a_loop() {
    let (bound, _) = bound(&mut bending_bar());
    let clip = &bound.clips()[0];
    let at = |playback| [-0.5, 0.5, 2.0, 2.5, 7.0, f32::NAN].map(|seconds| clip.time_at(seconds, playback));
    assert_eq!(at(Playback::Once), [0.0, 0.5, 2.0, 2.0, 2.0, 0.0]);
    assert_eq!(at(Playback::Loop), [1.5, 0.5, 0.0, 0.5, 1.0, 0.0]);
}

#[test]
fn an_animation_plays_from_a_bake_of_another_time_and_place() {
    let mut file = bending_bar();
    let (of_file, scene) = bound(&mut file);
    let mut elsewhere = Poses::default();
    let turned = Pose {
        translate: Vec3::new(1.0, 0.5, -2.0),
        rotate_degrees: Vec3::new(0.0, 40.0, 10.0),
        scale: 1.5,
        ..Pose::AS_BAKED
    };
    elsewhere.set(0, turned);
    let clip = of_file.clips()[0].name.clone();
    let mut baked = scene.clone();
    baked.place(&of_file.poses_at(0, 0.4, &elsewhere).unwrap()).unwrap();
    baked.clip_time = Some(ClipTime { clip, seconds: 0.4 });
    let again =
        BoundAnimation::new(animation::read(&file.write(), &ImportOptions::default()).unwrap(), &baked).unwrap();
    let now = |seconds: f32, poses: &Poses| {
        let since = again.poses_at(0, seconds, &baked.poses_since_baked(poses)).unwrap();
        posed(&since, &baked)
    };
    assert!(again.poses_at(0, 0.4, &baked.poses_since_baked(&elsewhere)).unwrap().is_empty(), "as baked");
    for (seconds, poses) in [(0.9, &elsewhere), (0.0, &Poses::default())] {
        let expected = posed(&of_file.poses_at(0, seconds, poses).unwrap(), &scene);
        assert!(farthest(&now(seconds, poses).positions, expected.positions.clone()) < 1e-4);
        assert!(farthest(&now(0.2, poses).positions, expected.positions) > 0.1, "negative control: another time");
    }
    let at_rest = |poses: &Poses| posed(&again.poses_at_rest(&baked.poses_since_baked(poses)), &baked).positions;
    for poses in [&elsewhere, &Poses::default()] {
        let expected = posed(poses, &scene).positions;
        assert!(farthest(&at_rest(poses), expected.clone()) < 1e-4);
        assert!(farthest(&now(0.4, poses).positions, expected) > 0.1, "negative control: as baked");
    }
    assert!(of_file.poses_at_rest(&Poses::default()).is_empty(), "it was baked at rest");
}
