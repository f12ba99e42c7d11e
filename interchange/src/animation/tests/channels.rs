//! Channels of clips: shared samplers, omitted channels, and names of clips.

use super::*;
use crate::import::import_with;
use std::sync::Arc;

const TRIANGLE: [f32; 9] = [0., 0., 0., 1., 0., 0., 1., 1., 0.];

/// Triangles, and a clip that moves all of them by one sampler of `keys` keyframes.
fn carried(nodes: usize, keys: usize) -> TestFile {
    let node = |k: usize| json!({ "name": format!("n{k}"), "mesh": 0, "translation": [2 * k, 0, 0] });
    let mut file = TestFile::new((0..nodes).map(node).collect(), nodes);
    file.mesh(&TRIANGLE, &[0, 1, 2], &[]);
    let times: Vec<f32> = (0..keys).map(|key| key as f32).collect();
    file.clip("up", 0, "translation", &times, &[0.0, 1.0, 0.0].repeat(keys), "LINEAR");
    let channel = |node| json!({ "sampler": 0, "target": { "node": node, "path": "translation" } });
    file.json["animations"][0]["channels"] = (0..nodes).map(channel).collect();
    file
}

/// Warnings of a file's import, and its animation.
fn read(path: &Path, budget: Option<u64>) -> (Vec<String>, Result<Animation, AnimationFileError>) {
    let options = ImportOptions { budget, ..Default::default() };
    (import_with(path, &options).unwrap().report.warnings, animation::read(path, &options))
}

/// The smallest budget in bytes that reads a scene, to a kilobyte.
fn least_budget(path: &Path) -> u64 {
    let is_enough = |budget| import_with(path, &ImportOptions { budget: Some(budget), ..Default::default() }).is_ok();
    let (mut below, mut enough) = (0u64, 1 << 30);
    while enough - below > 1000 {
        let middle = below.midpoint(enough);
        *if is_enough(middle) { &mut enough } else { &mut below } = middle;
    }
    enough
}

#[test]
fn the_keyframes_of_a_sampler_are_read_once_and_only_into_memory_that_there_is() {
    let mut file = carried(50, 20_000);
    let path = file.write();
    let least = least_budget(&path);
    let (warnings, animation) = read(&path, Some(least));
    assert!(warnings.iter().any(|w| w.contains("\"up\" cannot be played") && w.contains("MB")), "{warnings:?}");
    let error = animation.unwrap_err().to_string();
    assert!(["\"up\"", "keyframes", "MB", "moving.gltf"].iter().all(|said| error.contains(said)), "{error}");
    // Enough for the sampler once; a copy per channel would take 32 MB.
    let (warnings, animation) = read(&path, Some(least + 1_000_000));
    assert_eq!(warnings, [] as [String; 0]);
    let [first, .., last] = animation.as_ref().unwrap().clips[0].channels() else { panic!("50 channels") };
    assert!(Arc::ptr_eq(&first.keys, &last.keys));
}

#[test]
fn keyframes_may_be_sparse_over_zeros() {
    let mut file = carried(1, 2);
    let (index, up) = (file.shorts(&[1], "SCALAR"), file.floats(&[0.0, 1.0, 0.0], "VEC3"));
    let view = |accessor: usize| file.json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": view(index), "componentType": 5123 },
        "values": { "bufferView": view(up) },
    });
    let keys = file.json["animations"][0]["samplers"][0]["output"].as_u64().unwrap() as usize;
    let accessor = file.json["accessors"][keys].as_object_mut().unwrap();
    accessor.remove("bufferView");
    accessor.insert("sparse".into(), sparse);
    let (animation, scene) = bound(&mut file);
    let lifted = |height: f32| scene.mesh.positions.iter().map(move |&place| place + Vec3::Y * height);
    for time in [0.0, 0.5, 1.0] {
        assert!(farthest(&at(&animation, time, &scene).positions, lifted(time)) < 1e-5, "{time}");
    }
    assert!(farthest(&at(&animation, 1.0, &scene).positions, lifted(0.0)) > 0.9, "negative control");
}

#[test]
fn a_second_channel_for_one_property_is_left_out_and_told() {
    let mut file = bending_bar();
    let still = file.floats(&[NO_TURN, NO_TURN].concat(), "VEC4");
    let clip = &mut file.json["animations"][0];
    let mut sampler = clip["samplers"][0].clone();
    sampler["output"] = json!(still);
    clip["samplers"].as_array_mut().unwrap().push(sampler);
    let second = json!({ "sampler": 1, "target": { "node": 2, "path": "rotation" } });
    clip["channels"].as_array_mut().unwrap().push(second);
    let path = file.write();
    let scene = import(&path).unwrap().scene;
    let (warnings, animation) = read(&path, None);
    let animation = animation.unwrap();
    for told in [&warnings, &animation.warnings] {
        assert!(matches!(&told[..], [told] if told.contains("\"bend\"") && told.contains("first")), "{told:?}");
    }
    let mesh = at(&BoundAnimation::new(animation, &scene).unwrap(), 2.0, &scene);
    assert!(farthest(&mesh.positions, scene.mesh.positions.iter().map(|&p| bent(p, FRAC_PI_2))) < 1e-5);
    file.json["animations"][0]["channels"][1]["target"]["node"] = json!(1);
    assert_eq!(read(&file.write(), None).0, [] as [String; 0], "negative control: another node");
}

#[test]
fn clips_of_equal_names_are_numbered() {
    let mut file = bar(NO_TURN);
    let turns = [NO_TURN, RIGHT_ANGLE].concat();
    for (name, end) in [("Take 001", 1.0), ("Take 001", 2.0), ("Take 001 (2)", 3.0), ("Take 001", -1.0), ("run", 4.0)] {
        file.clip(name, 2, "rotation", &[0.0, end], &turns, "LINEAR");
    }
    let (warnings, animation) = read(&file.write(), None);
    let animation = animation.unwrap();
    let names: Vec<&str> = animation.clips.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["Take 001", "Take 001 (3)", "Take 001 (2)", "run"]);
    for (index, clip) in animation.clips.iter().enumerate() {
        assert_eq!(animation.clip(Some(&clip.name)).unwrap(), index);
    }
    assert!(warnings[0].contains("\"Take 001 (4)\" cannot be played"), "{warnings:?}");
    assert!(animation.clip(Some("Take 001 (4)")).unwrap_err().to_string().contains("must be a number from 0 on"));
}

/// The bending bar with an additional channel that moves no node.
fn with_pointer() -> TestFile {
    let mut file = bending_bar();
    let pointer = json!({ "pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor" });
    let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } });
    let channels = file.json["animations"][0]["channels"].as_array_mut().unwrap();
    channels.insert(0, json!({ "sampler": 0, "target": target }));
    file.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    file
}

/// A file as a GLB beside it.
fn as_glb(path: &Path) -> PathBuf {
    let glb = gltf::binary::Glb {
        header: gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 },
        json: std::fs::read(path).unwrap().into(),
        bin: None,
    };
    let path = path.with_extension("glb");
    std::fs::write(&path, glb.to_vec().unwrap()).unwrap();
    path
}

#[test]
fn channels_that_move_no_node_are_left_out_and_told_and_the_others_play() {
    let mut file = with_pointer();
    let path = file.write();
    file.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let paths = [path.clone(), as_glb(&path), file.write()];
    for path in paths {
        let scene = import(&path).unwrap().scene;
        let (warnings, animation) = read(&path, None);
        let animation = animation.unwrap();
        for told in [&warnings, &animation.warnings] {
            let [told] = &told[..] else { panic!("{told:?}") };
            assert!(["\"bend\"", "KHR_animation_pointer"].iter().all(|said| told.contains(said)), "{told}");
        }
        let mesh = at(&BoundAnimation::new(animation, &scene).unwrap(), 2.0, &scene);
        assert!(farthest(&mesh.positions, scene.mesh.positions.iter().map(|&p| bent(p, FRAC_PI_2))) < 1e-5);
        assert!(farthest(&mesh.positions, scene.mesh.positions.iter().copied()) > 0.5, "negative control");
    }
}

#[test]
fn a_clip_that_moves_no_node_at_all_is_told_and_the_scene_shows() {
    let mut file = with_pointer();
    file.json["animations"][0]["channels"].as_array_mut().unwrap().truncate(1);
    let (warnings, animation) = read(&file.write(), None);
    assert!(warnings.iter().any(|w| w.contains("\"bend\" cannot be played: it moves no node")), "{warnings:?}");
    assert!(animation.unwrap_err().to_string().contains("it moves no node"));
    file.json["animations"][0]["channels"][0].as_object_mut().unwrap().remove("target");
    let error = import(&file.write()).unwrap_err().to_string();
    assert!(error.contains("target") && error.contains("moving.gltf"), "negative control: {error}");
}
