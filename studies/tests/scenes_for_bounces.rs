//! Scenes that barely suit a bake of bounced light give a message with a remedy on the command line.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

/// Few sources and functions.
const SMALL: &str = "--mode all --sources 256 --lights 256 --pilot-clusters 16 --max-vertices 300 --levels 2 \
                     --sender-levels 1 --gather-rays 16 --coarse-radius 0.6";

/// Faces of a box from corner `a` to corner `b`, outward or inward.
fn add_box(text: &mut String, first: &mut usize, [a, b]: [[f32; 3]; 2], inward: bool) {
    for i in 0..8 {
        let corner: Vec<String> = (0..3).map(|axis| [a, b][i >> axis & 1][axis].to_string()).collect();
        *text += &format!("v {}\n", corner.join(" "));
    }
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let mut face = face.map(|corner| (*first + corner).to_string());
        if inward {
            face.reverse();
        }
        *text += &format!("f {}\n", face.join(" "));
    }
    *first += 8;
}

/// A room of 2 m with a box in it, of one color.
fn room(folder: &Path, name: &str, color: f32) {
    let (mut text, mut first) = (format!("mtllib {name}.mtl\nusemtl paint\n"), 1);
    add_box(&mut text, &mut first, [[-1.0; 3], [1.0; 3]], true);
    add_box(&mut text, &mut first, [[0.2, -0.9, 0.1], [0.7, -0.3, 0.6]], false);
    fs::write(folder.join(format!("{name}.obj")), text).expect("a writable folder");
    let paint = format!("newmtl paint\nKd {color} {color} {color}\n");
    fs::write(folder.join(format!("{name}.mtl")), paint).expect("a writable folder");
}

/// Output of `bake`, and whether it succeeded.
fn bake(folder: &Path, scene: &str, more: &str) -> (bool, String) {
    let options = format!("bake {scene} -o a.cuts {SMALL} --progress json {more}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_precompute"));
    let Output { status, stderr, .. } =
        command.args(options.split_whitespace()).current_dir(folder).output().expect("the program starts");
    let text = String::from_utf8_lossy(&stderr).into_owned();
    assert!(!text.contains("panicked"), "{text}");
    (status.success(), text)
}

#[test]
fn a_scene_without_a_closed_space_is_baked_with_a_remark() {
    let folder = tempfile::tempdir().unwrap();
    let (mut text, mut first) = ("v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\n".to_owned(), 5);
    add_box(&mut text, &mut first, [[-0.3, 0.2, -0.3], [0.3, 0.8, 0.3]], false);
    fs::write(folder.path().join("open.obj"), text).unwrap();
    let (baked, said) = bake(folder.path(), "open.obj", "");
    assert!(baked && said.contains("meet no surface") && said.contains("--viewpoint"), "{said}");
    room(folder.path(), "room", 0.5);
    let (baked, said) = bake(folder.path(), "room.obj", "");
    assert!(baked && !said.contains("warning"), "a room is closed: {said}");
}

#[test]
fn viewpoints_that_are_not_valid_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    room(folder.path(), "room", 0.5);
    for (viewpoint, words) in [
        ("0.4,-0.6,0.3", "inside something solid"),
        ("0,9,0", "--viewpoint"),
        ("1e8,0,0", "no surface is seen"),
        ("1e30,0,0", "beyond the limit"),
        ("nan,0,0", "is not a number"),
    ] {
        let (baked, said) = bake(folder.path(), "room.obj", &format!("--viewpoint {viewpoint}"));
        assert!(!baked && said.contains(words) && said.contains("viewpoint"), "{viewpoint}: {said}");
    }
    assert!(!folder.path().join("a.cuts").exists());
    assert!(bake(folder.path(), "room.obj", "--viewpoint 0,0.2,0").0);
}

#[test]
fn a_closed_room_that_reflects_everything_is_remarked_upon() {
    let folder = tempfile::tempdir().unwrap();
    for (color, remarked) in [(1.0, true), (0.9, false)] {
        room(folder.path(), "white", color);
        let (baked, said) = bake(folder.path(), "white.obj", "");
        assert!(baked, "{said}");
        assert_eq!(said.contains("reflects nearly all light") && said.contains("base colors"), remarked, "{said}");
    }
}

#[test]
fn zero_area_surfaces_do_no_harm_and_alone_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    room(folder.path(), "room", 0.5);
    let mut text = fs::read_to_string(folder.path().join("room.obj")).unwrap();
    text += "v 0 0 0\nv 0.5 0 0\nv 1 0 0\nf 17 18 19\nf 17 17 17\nf 17 18 18\n";
    fs::write(folder.path().join("slivers.obj"), text).unwrap();
    let (baked, said) = bake(folder.path(), "slivers.obj", "");
    assert!(baked, "{said}");
    fs::write(folder.path().join("flat.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
    let (baked, said) = bake(folder.path(), "flat.obj", "");
    assert!(!baked && said.contains("flat.obj"), "{said}");
}
