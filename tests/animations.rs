//! Animations, from end to end: pictures at a time of a clip, references of the same, and sequences.

use crate::common::{Folder, read};
use lapidary_interchange::image;

const TOWER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/bending-tower/bending-tower.gltf");

const VIEW: &str = "--env sun-sky:50 --size 48x36 --background black";

/// The bundled tower, baked with few lights.
fn baked() -> Folder {
    let folder = Folder::new();
    folder.succeed(&format!(
        "bake {TOWER} -o a.cuts --lights 1024 --pilot-clusters 64 --max-vertices 4000 --progress none"
    ));
    folder
}

fn pixels(folder: &Folder, name: &str) -> Vec<glam::Vec3> {
    image::read(&folder.path(name)).expect("a picture").pixels
}

#[test]
fn a_picture_at_a_time_is_close_to_its_reference_and_the_baked_one_is_not() {
    let folder = baked();
    let render = |options: &str| folder.succeed(&format!("render a.cuts {VIEW} --backend cpu {options}"));
    let at = |time: &str| format!("--animation {TOWER} --time {time}");
    render("--out baked.exr");
    render(&format!("{} --out bent.exr --stats bent.json", at("0.5")));
    folder.succeed(&format!("reference a.cuts {VIEW} {} --out reference.exr", at("0.5")));
    assert_eq!(folder.json("bent.json")["tier"], "implicit");
    let tells = |file: &str, what: &str| read(&folder.path(file)).windows(what.len()).any(|at| at == what.as_bytes());
    assert!(tells("bent.exr", "lapidary.clip.seconds") && tells("bent.exr", "Bend"));
    assert!(!tells("baked.exr", "lapidary.clip"), "negative control");
    let error = |picture: &str| {
        folder.succeed(&format!("compare {picture} reference.exr --json m.json"));
        folder.json("m.json")["rel_rmse"].as_f64().expect("a number")
    };
    let (near, as_baked) = (error("bent.exr"), error("baked.exr"));
    assert!(near < 0.25 && as_baked > 2.0 * near, "{near}, negative control {as_baked}");
    // The clip begins as the file is at rest, and another one leaves the tower where it is.
    render(&format!("{} --out rest.exr --stats rest.json", at("0")));
    assert_eq!(folder.json("rest.json")["tier"], "cuts");
    assert!(pixels(&folder, "rest.exr") == pixels(&folder, "baked.exr"));
    render(&format!("{} --clip Block --out block.exr", at("0.5")));
    assert!(pixels(&folder, "block.exr") != pixels(&folder, "bent.exr"));
}

#[test]
fn a_sequence_plays_a_clip_and_goes_on_where_it_stopped() {
    let folder = baked();
    let sequence = |options: &str| format!("sequence a.cuts {VIEW} --backend cpu --animation {TOWER} {options}");
    folder.succeed(&sequence("--fps 2 --frames 3 --out rate/f.#.exr"));
    folder.succeed(&sequence("--time 0..1 --frames 3 --out span/f.#.exr"));
    for frame in 1..=3 {
        assert!(pixels(&folder, &format!("rate/f.{frame}.exr")) == pixels(&folder, &format!("span/f.{frame}.exr")));
    }
    let middle = format!("render a.cuts {VIEW} --backend cpu --animation {TOWER} --time 0.5 --out still.exr");
    folder.succeed(&middle);
    assert!(pixels(&folder, "still.exr") == pixels(&folder, "span/f.2.exr"));
    assert!(pixels(&folder, "still.exr") != pixels(&folder, "span/f.1.exr"), "negative control");
    let record = folder.json("span/f.json");
    assert_eq!(record["frames"][1]["values"]["time@Bend"], 0.5);
    std::fs::remove_file(folder.path("span/f.2.exr")).expect("a frame");
    folder.succeed(&sequence("--time 0..1 --frames 3 --resume --out span/f.#.exr"));
    assert!(pixels(&folder, "still.exr") == pixels(&folder, "span/f.2.exr"));
    let other = folder.fail(&sequence("--clip Block --time 0..1 --frames 3 --resume --out span/f.#.exr"));
    assert!(other.contains("another sequence"), "{other}");
}

#[test]
fn an_animation_that_cannot_be_played_is_told_and_nothing_is_written() {
    let folder = baked();
    folder.bake("other.cuts", "");
    let clip = |options: &str| format!("a.cuts --animation {TOWER} {options}");
    for (options, said) in [
        ("a.cuts --time 1", "add --animation FILE.gltf"),
        ("a.cuts --clip Bend", "add --time SECONDS"),
        (&*clip(""), "add --time SECONDS"),
        (&clip("--time 1 --clip Run"), "no clip \"Run\"; it has \"Bend\", \"Block\""),
        ("a.cuts --animation scene.obj --time 1", "only .gltf and .glb"),
        ("a.cuts --animation none.gltf --time 1", "none.gltf"),
        (&format!("other.cuts --animation {TOWER} --time 1"), "the file has 6 objects, the scene 2"),
    ] {
        for command in ["render", "reference"] {
            let errors = folder.fail(&format!("{command} {options} {VIEW} --out x.exr"));
            assert!(errors.contains(said), "{command} {options}: {errors}");
        }
        assert!(!folder.path("x.exr").exists());
    }
    for (options, said) in [
        ("--time 0..1 --fps 24", "leave --fps out"),
        ("--loop", "add one, or leave it out"),
        ("--time 1", "nothing changes from frame to frame"),
    ] {
        let errors = folder.fail(&format!("sequence {} {VIEW} --out x/f.#.png", clip(options)));
        assert!(errors.contains(said), "{options}: {errors}");
    }
}
