//! Invalid files: they show at rest with a warning, and unplayable clips give the reason.

use super::*;

/// Warnings of an import, and the same file's animation.
fn read(file: &mut TestFile) -> (Vec<String>, Result<Animation, AnimationFileError>) {
    let path = file.write();
    let imported = import(&path).unwrap();
    assert!(imported.scene.mesh.positions.iter().all(|p| p.is_finite()));
    (imported.report.warnings, animation::read(&path, &ImportOptions::default()))
}

fn refused(file: &mut TestFile) -> String {
    let (warnings, read) = read(file);
    let error = read.unwrap_err().to_string();
    assert!(error.contains("moving.gltf"), "{error}");
    assert!(warnings.iter().any(|warning| warning.contains("cannot be played")), "{warnings:?}");
    error
}

#[test]
fn a_skin_that_cannot_be_used_is_told_and_its_object_shows_by_its_node() {
    type Damage = fn(&mut TestFile);
    let damages: [(Damage, &str); 8] = [
        (|f| drop(attributes(f).remove("WEIGHTS_0")), "joints or weights alone"),
        (
            |f| f.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": position(f) }),
            "no joints and weights",
        ),
        (|f| replace_floats(f, "WEIGHTS_0", 80, 0.0), "the weights of vertex 0 are zero"),
        (|f| replace_floats(f, "WEIGHTS_0", 80, f32::NAN), "the weights of vertex 0"),
        (|f| replace_joints(f, &[9; 80]), "follows joint 9, but there are 2"),
        (|f| change(f, "JOINTS_0", "count", &json!(19)), "19 joints for 20 vertices"),
        (|f| change(f, "WEIGHTS_0", "type", &json!("VEC3")), "is of type"),
        (
            |f| {
                let matrix = f.floats(&[0.0; 16], "MAT4");
                f.json["skins"][0]["inverseBindMatrices"] = json!(matrix);
            },
            "1 inverse bind matrices for 2 joints",
        ),
    ];
    for (damage, said) in damages {
        let mut file = bending_bar();
        damage(&mut file);
        let path = file.write();
        let imported = import(&path).unwrap();
        let warnings = &imported.report.warnings;
        assert!(
            warnings.iter().any(|w| w.contains("\"bar\"") && w.contains(said) && w.contains("export")),
            "{said}: {warnings:?}"
        );
        assert!(imported.scene.mesh.bounds().min.distance(Vec3::new(6.8, 8.0, 8.9)) < 1e-5, "placed by its node");
        let animation = animation::read(&path, &ImportOptions::default()).unwrap();
        let bound = BoundAnimation::new(animation, &imported.scene).unwrap();
        assert!(bound.poses_at(0, 2.0, &Poses::default()).unwrap().is_empty());
    }
}

fn attributes(file: &mut TestFile) -> &mut serde_json::Map<String, serde_json::Value> {
    file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap()
}

fn accessor(file: &TestFile, attribute: &str) -> usize {
    file.json["meshes"][0]["primitives"][0]["attributes"][attribute].as_u64().unwrap() as usize
}

fn change(file: &mut TestFile, attribute: &str, key: &str, value: &serde_json::Value) {
    let accessor = accessor(file, attribute);
    file.json["accessors"][accessor][key] = value.clone();
}

fn position(file: &TestFile) -> usize {
    accessor(file, "POSITION")
}

fn replace_floats(file: &mut TestFile, attribute: &str, count: usize, value: f32) {
    let accessor = file.floats(&vec![value; count], "VEC4");
    attributes(file).insert(attribute.into(), json!(accessor));
}

fn replace_joints(file: &mut TestFile, joints: &[u16]) {
    let accessor = file.shorts(joints, "VEC4");
    attributes(file).insert("JOINTS_0".into(), json!(accessor));
}

#[test]
fn morph_targets_that_do_not_fit_are_told_and_left_out() {
    let triangle = [0., 0., 0., 1., 0., 0., 1., 1., 0.];
    for (numbers, kind, said) in [
        (vec![0.0; 6], "VEC3", "2 morph targets for 3 vertices"),
        (vec![0.0; 12], "VEC4", "is of type"),
        (vec![f32::NAN; 9], "VEC3", "not a finite number"),
    ] {
        let mut file = TestFile::new(json!([{ "name": "flag", "mesh": 0, "weights": [1] }]), 1);
        file.mesh(&triangle, &[0, 1, 2], &[]);
        let target = file.floats(&numbers, kind);
        file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
        let imported = import(&file.write()).unwrap();
        let warnings = &imported.report.warnings;
        assert!(warnings.iter().any(|w| w.contains("\"flag\"") && w.contains(said)), "{warnings:?}");
    }
}

#[test]
fn damaged_clips_say_what_is_wrong_and_others_play() {
    let turns = [NO_TURN, RIGHT_ANGLE].concat();
    for (path, times, values, said) in [
        ("rotation", &[2.0, 1.0][..], &turns[..], "times must ascend"),
        ("rotation", &[0.0, f32::NAN], &turns, "must be a number from 0 on"),
        ("rotation", &[0.0, 1.0, 2.0], &turns, "8 numbers for 3 keyframes, which need 12"),
        ("translation", &[0.0], &[0.0, f32::INFINITY, 0.0], "not a finite number"),
        ("scale", &[0.0], &[1.0, -1.0, 1.0], "turns surfaces inside out"),
    ] {
        let mut file = bar(NO_TURN);
        file.clip("broken", 2, path, times, values, "LINEAR");
        let error = refused(&mut file);
        assert!(error.contains("\"broken\"") && error.contains(said), "{error}");
        file.clip("whole", 2, "rotation", &[0.0, 2.0], &turns, "LINEAR");
        let animation = animation::read(&file.write(), &ImportOptions::default()).unwrap();
        assert_eq!(animation.clip(None).unwrap(), 0);
        assert!(animation.clip(Some("broken")).unwrap_err().to_string().contains(said));
        let unknown = animation.clip(Some("run")).unwrap_err().to_string();
        assert!(unknown.contains("no clip \"run\"; it has \"whole\""), "{unknown}");
    }
}

#[test]
fn clips_with_accessors_of_other_types_or_of_nothing_are_damaged() {
    type Damage = fn(&mut serde_json::Value, usize);
    let damages: [(Damage, &str); 5] = [
        (|json, output| json["accessors"][output]["type"] = json!("VEC3"), "is of type"),
        (|json, output| json["accessors"][output]["componentType"] = json!(5125), "is of type"),
        (|json, output| json["accessors"][output]["count"] = json!(4000), "does not fit"),
        (
            |json, _| json["animations"][0]["channels"][0]["target"]["node"] = json!(99),
            "has a missing node or an unknown property",
        ),
        (
            |json, _| json["animations"][0]["channels"][0]["target"]["path"] = json!("color"),
            "has a missing node or an unknown property",
        ),
    ];
    for (damage, said) in damages {
        let mut file = bending_bar();
        let output = file.json["animations"][0]["samplers"][0]["output"].as_u64().unwrap() as usize;
        damage(&mut file.json, output);
        let error = refused(&mut file);
        assert!(error.contains("\"bend\"") && error.contains(said), "{error}");
    }
}

#[test]
fn a_file_without_animation_or_of_another_format_is_told() {
    let (warnings, animation) = read(&mut bar(NO_TURN));
    assert!(warnings.is_empty() && animation.unwrap_err().to_string().contains("has no animation"));
    let error = animation::read(Path::new("a.obj"), &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("only .gltf and .glb"), "{error}");
    let error = animation::read(Path::new("none.gltf"), &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("none.gltf"), "{error}");
}

#[test]
fn a_clip_of_no_length_is_one_pose() {
    let mut file = bar(NO_TURN);
    file.clip("bent", 2, "rotation", &[0.0], &RIGHT_ANGLE, "LINEAR");
    let (bound, scene) = bound(&mut file);
    assert_eq!(bound.clips()[0].seconds(), 0.0);
    for seconds in [0.0, 3.0, f32::NAN] {
        let expected = scene.mesh.positions.iter().map(|&p| bent(p, FRAC_PI_2));
        assert!(farthest(&at(&bound, seconds, &scene).positions, expected) < 1e-5);
    }
}

#[test]
fn a_scale_of_nothing_leaves_something_tiny() {
    let mut file = bar(NO_TURN);
    file.clip("vanish", 1, "scale", &[0.0, 1.0], &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0], "LINEAR");
    let (bound, scene) = bound(&mut file);
    let mesh = at(&bound, 1.0, &scene);
    assert!((mesh.bounds().diagonal() / scene.mesh.bounds().diagonal() / clip::LEAST_SCALE - 1.0).abs() < 1e-2);
    assert!(mesh.normals.iter().zip(&scene.mesh.normals).all(|(a, b)| a.distance(*b) < 1e-2));
}

#[test]
fn what_goes_out_of_reach_is_told_with_clip_time_and_object() {
    let mut file = bar(NO_TURN);
    file.clip("away", 1, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1e30, 0.0, 0.0], "LINEAR");
    let (bound, _) = bound(&mut file);
    let error = bound.poses_at(0, 1.0, &Poses::default()).unwrap_err().to_string();
    assert!(["\"away\"", "\"bar\"", "at 1 s", "moving.gltf"].iter().all(|said| error.contains(said)), "{error}");
    assert!(bound.poses_at(0, 0.0, &Poses::default()).is_ok(), "negative control");
    assert!(bound.poses_at(1, 0.0, &Poses::default()).unwrap_err().to_string().contains("it has \"away\""));
}

#[test]
fn a_scene_that_was_not_baked_of_the_file_is_told() {
    let mut file = bending_bar();
    let path = file.write();
    let scene = import(&path).unwrap().scene;
    let bind = |change: &dyn Fn(&mut Scene)| {
        let mut other = scene.clone();
        change(&mut other);
        let animation = animation::read(&path, &ImportOptions::default()).unwrap();
        BoundAnimation::new(animation, &other).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(bind(&|_| {}), Ok(()));
    assert_eq!(bind(&|scene| lapidary_core::ground::add_ground(scene)), Ok(()), "a ground is no object of the file");
    let renamed = bind(&|scene| scene.objects[0].name = "pole".into()).unwrap_err();
    assert!(renamed.contains("an object \"bar\" where the scene has \"pole\""), "{renamed}");
    let twice = || {
        let mut animation = animation::read(&path, &ImportOptions::default()).unwrap();
        animation.objects.push("bar 2".into());
        animation
    };
    let of_twice = |name: &str| {
        let mut other = scene.clone();
        other.objects.push(lapidary_core::scene::Object { name: name.into() });
        BoundAnimation::new(twice(), &other).map(drop).map_err(|error| error.to_string())
    };
    assert!(!of_twice("bar").is_err_and(|told| told.contains("where the scene has")), "older bakes have equal names");
    assert!(of_twice("rod").is_err_and(|told| told.contains("\"bar 2\" where the scene has \"rod\"")));
    let more = bind(&|scene| scene.objects.push(scene.objects[0].clone())).unwrap_err();
    assert!(more.contains("the file has 1 objects, the scene 2"), "{more}");
    let moved = bind(&|scene| scene.mesh.positions.iter_mut().for_each(|p| p.x += 0.5)).unwrap_err();
    assert!(moved.contains("\"bar\"") && moved.contains("bake it again"), "{moved}");
}
