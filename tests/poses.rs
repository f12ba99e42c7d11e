//! Posed objects, from end to end: references trace them, and the preview by implicit visibility is close.

use crate::common::Folder;
use lapidary_interchange::image;

/// Looks down on box and floor.
const VIEW: &str = "--env sun-sky:50 --eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 64x48 --background black";

/// The small scene with a finer floor, and poses of its box: turned and moved, and carried away.
fn baked() -> Folder {
    let folder = Folder::new();
    folder.succeed("bake scene.obj -o a.cuts --lights 1024 --pilot-clusters 64 --max-vertices 3000 --progress none");
    let poses = |pose: &str| format!("{{\"objects\": {{\"box\": {pose}}}}}");
    folder.write("moved.json", poses(r#"{"translate": [0.5, 0, 0.2], "rotate_degrees": [0, 30, 0]}"#));
    folder.write("away.json", poses(r#"{"translate": [0, 5000, 0]}"#));
    folder.write("as-baked.json", r#"{"objects": {}}"#.into());
    folder
}

fn error(folder: &Folder, picture: &str, reference: &str) -> f64 {
    folder.succeed(&format!("compare {picture} {reference} --json m.json"));
    folder.json("m.json")["rel_rmse"].as_f64().expect("a number")
}

#[test]
fn a_preview_of_posed_objects_is_close_to_their_reference_and_the_baked_picture_is_not() {
    let folder = baked();
    let render = |options: &str| folder.succeed(&format!("render a.cuts {VIEW} --backend cpu {options}"));
    render("--out baked.exr");
    for pose in ["moved", "away"] {
        render(&format!("--pose {pose}.json --out {pose}.exr --stats {pose}-stats.json"));
        folder.succeed(&format!("reference a.cuts {VIEW} --pose {pose}.json --out {pose}-reference.exr"));
        assert_eq!(folder.json(&format!("{pose}-stats.json"))["tier"], "implicit");
        let near = error(&folder, &format!("{pose}.exr"), &format!("{pose}-reference.exr"));
        let as_baked = error(&folder, "baked.exr", &format!("{pose}-reference.exr"));
        assert!(near < 0.15 && as_baked > 2.0 * near, "{pose}: {near}, negative control {as_baked}");
    }
}

#[test]
fn a_hidden_object_is_gone_and_comes_back_from_a_bake_without_it() {
    let folder = baked();
    folder.write("hidden.json", r#"{"objects": {"box": {"hidden": true}}}"#.into());
    let render = |options: &str| folder.succeed(&format!("render {VIEW} --backend cpu {options}"));
    for pose in ["hidden", "away"] {
        folder.succeed(&format!("reference a.cuts {VIEW} --pose {pose}.json --out {pose}-reference.exr"));
    }
    let read = |name: &str| image::read(&folder.path(name)).expect("a picture").pixels;
    assert!(read("hidden-reference.exr") == read("away-reference.exr"), "as if it were carried away");
    render("a.cuts --out baked.exr");
    render("a.cuts --pose hidden.json --out preview.exr");
    folder.succeed("bake --update a.cuts --pose hidden.json -o hidden.cuts --progress none");
    render("hidden.cuts --out updated.exr");
    let as_baked = error(&folder, "baked.exr", "hidden-reference.exr");
    for picture in ["preview", "updated"] {
        let near = error(&folder, &format!("{picture}.exr"), "hidden-reference.exr");
        assert!(near < 0.15 && as_baked > 2.0 * near, "{picture}: {near}, negative control {as_baked}");
    }
    assert!(folder.succeed("info hidden.cuts").contains("hidden     box"));
    folder.succeed("verify hidden.cuts");
    folder.succeed("bake --update hidden.cuts --pose as-baked.json -o back.cuts --progress none");
    render("back.cuts --out back.exr");
    let (back, gone) = (error(&folder, "back.exr", "baked.exr"), error(&folder, "updated.exr", "baked.exr"));
    assert!(back < 0.01 && gone > 10.0 * back, "{back}, negative control {gone}");
    let refused = folder.fail("bake scene.obj -o s.cuts --pose hidden.json --shard 1/2 --progress none");
    assert!(refused.contains("--update"), "{refused}");
}

#[test]
fn a_scene_as_baked_is_the_same_picture_by_cuts() {
    let folder = baked();
    folder.succeed(&format!("render a.cuts {VIEW} --backend cpu --out a.exr"));
    folder.succeed(&format!("render a.cuts {VIEW} --backend cpu --pose as-baked.json --out b.exr --stats b.json"));
    assert_eq!(folder.json("b.json")["tier"], "cuts");
    let read = |name: &str| image::read(&folder.path(name)).expect("a picture").pixels;
    assert!(read("a.exr") == read("b.exr"));
    folder.succeed(&format!("render a.cuts {VIEW} --backend cpu --pose moved.json --out c.exr"));
    assert!(read("a.exr") != read("c.exr"), "negative control");
}

#[test]
fn a_sequence_goes_on_only_with_a_bake_of_the_same_poses() {
    let folder = baked();
    let bake = |pose: &str| folder.bake("a.cuts", &format!("--pose {pose}.json"));
    let sequence =
        |more: &str| format!("sequence a.cuts {VIEW} --backend cpu --turn camera --frames 2 --out f.#.exr {more}");
    bake("moved");
    folder.succeed(&sequence(""));
    std::fs::remove_file(folder.path("f.2.exr")).expect("a frame");
    bake("as-baked");
    let refused = folder.fail(&sequence("--resume"));
    assert!(refused.contains("their bake.poses differs"), "{refused}");
    bake("moved");
    folder.succeed(&sequence("--resume"));
}

#[test]
fn a_pose_that_cannot_be_is_told_and_nothing_is_written() {
    let folder = baked();
    folder.write("unknown.json", r#"{"objects": {"bx": {"scale": 2}}}"#.into());
    folder.write("nothing.json", r#"{"objects": {"box": {"scale": 0}}}"#.into());
    folder.write(
        "far.json",
        r#"{"objects": {"box": {"translate": [9e8, 0, 0], "scale": 1e4}, "floor": {"translate": [1e9, 0, 0], "scale": 1e4}}}"#.into(),
    );
    for (file, said) in [
        ("unknown.json", "no object \"bx\""),
        ("nothing.json", "must be above 0"),
        ("far.json", "cannot be posed this way"),
        ("none.json", "cannot read"),
    ] {
        for command in ["render", "reference"] {
            let errors = folder.fail(&format!("{command} a.cuts {VIEW} --pose {file} --out x.exr"));
            assert!(errors.contains(said), "{command}: {errors}");
        }
        assert!(!folder.path("x.exr").exists());
    }
    let refused = folder
        .fail(&format!("reference a.cuts {VIEW} --pose moved.json --components indirect --kind samples --out x.exr"));
    assert!(refused.contains("use --kind path"), "{refused}");
}
