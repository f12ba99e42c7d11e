//! `looks`, and `render` of a session, from end to end.

use crate::common::Folder;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use serde_json::{Value, json};

/// A baked scene and a session of it with two looks: a quarter of the light, and a red material.
fn session() -> Folder {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    write(&folder, |_| ());
    folder
}

fn write(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let light = |intensity: f32| json!({ "spec": "constant:1,1,1", "intensity": intensity });
    let white = json!({ "name": "white", "parameters": { "base_color": [0.8, 0.8, 0.8] } });
    let red = json!({ "name": "white", "parameters": { "base_color": [0.8, 0.0, 0.0] } });
    let mut session = json!({
        "lapidary_session": 2,
        "dataset": "a.cuts",
        "materials": [white],
        "environment": light(1.0),
        "camera": { "eye": [0.5, 3.0, 3.0], "target": [0.0, 0.3, 0.0], "up": [0.0, 1.0, 0.0], "fov_y_degrees": 35.0 },
        "view": { "background": "flat", "background_color": [0.0, 0.0, 0.0] },
        "looks": [
            { "name": "Dim", "environment": light(0.25) },
            { "name": "Red/1", "materials": [red] },
        ],
    });
    change(&mut session);
    folder.write("a.lapidary", session.to_string());
}

const SMALL: &str = "--size 48x36 --aa 1 --backend cpu";

fn picture(folder: &Folder, name: &str) -> Image {
    image::read(&folder.path(name)).expect("a picture")
}

/// The least and the largest ratio of a channel between two pictures, where it is not black.
fn ratios(a: &Image, b: &Image, channel: usize) -> (f32, f32) {
    assert!(a.pixels.iter().any(|pixel| pixel[channel] > 0.1), "there is something to see");
    let pairs = a.pixels.iter().zip(&b.pixels).filter(|(a, _)| a[channel] > 1e-3);
    let all = pairs.map(|(a, b)| b[channel] / a[channel]);
    all.fold((f32::MAX, 0.0), |(least, most), ratio| (least.min(ratio), most.max(ratio)))
}

#[test]
fn looks_are_listed_and_rendered_one_by_one_and_all() {
    let folder = session();
    assert_eq!(folder.succeed("looks a.lapidary"), "Dim: light\nRed/1: materials\n");
    folder.succeed(&format!("render a.lapidary {SMALL} --out shown.exr"));
    folder.succeed(&format!("render a.lapidary --look Dim {SMALL} --out dim.exr --out dim.png"));
    let told = folder.succeed(&format!("render a.lapidary --all {SMALL} --out all.exr"));
    assert!(told.contains("all-Dim.exr: 48 x 36") && told.contains("all-Red-1.exr"), "{told}");
    let [shown, dim, red] = ["shown.exr", "dim.exr", "all-Red-1.exr"].map(|name| picture(&folder, name));
    assert_eq!((shown.size, picture(&folder, "dim.png").size), ([48, 36], [48, 36]));
    let (least, most) = ratios(&shown, &dim, 0);
    assert!((least - 0.25).abs() < 1e-4 && (most - 0.25).abs() < 1e-4, "{least} to {most}");
    let green = ratios(&shown, &red, 1).1;
    assert!(green < 0.4, "only the white highlight is left of green: {green}");
    let whole = |image: &Image, channel: usize| image.pixels.iter().map(|pixel| pixel[channel]).sum::<f32>();
    let stays = whole(&red, 0) / whole(&shown, 0);
    assert!((stays - 1.0).abs() < 0.05, "its red stays: {stays}");
    assert!(dim == picture(&folder, "all-Dim.exr"), "the same by itself and among all");
    write(&folder, |session| session["looks"][1]["name"] = "dim".into());
    let told = folder.succeed(&format!("render a.lapidary --all {SMALL} --out all.exr"));
    assert!(told.contains("all-Dim.exr:") && told.contains("all-dim 2.exr:"), "told apart on every system: {told}");
}

#[test]
fn what_is_not_there_is_told_with_the_remedy() {
    let folder = session();
    let told = folder.fail("render a.lapidary --look Blue --out a.png");
    assert!(told.contains("no look \"Blue\"; it has \"Dim\", \"Red/1\""), "{told}");
    let told = folder.fail("render a.lapidary --size 32768x8192 --aa 1 --out a.lapidary");
    assert!(told.contains("(a.lapidary)") && told.contains("extension"), "no picture: {told}");
    write(&folder, |session| drop(session.as_object_mut().map(|session| session.remove("looks"))));
    assert_eq!(folder.succeed("looks a.lapidary"), "");
    assert!(folder.fail("render a.lapidary --all --out a.png").contains("has no looks; add one in the window"));
    write(&folder, |session| session["looks"][1]["name"] = "Dim".into());
    let output = folder.run("looks a.lapidary");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "Dim: light\nDim 2: materials\n");
    assert!(String::from_utf8_lossy(&output.stderr).contains("it is now \"Dim 2\""));
    write(&folder, |session| session["looks"][0]["environment"]["spec"] = "gone.hdr".into());
    assert!(folder.fail(&format!("render a.lapidary {SMALL} --out a.png")).contains("gone.hdr"));
    write(&folder, |session| session["dataset"] = "other.cuts".into());
    let told = folder.fail(&format!("render a.lapidary {SMALL} --out a.png"));
    assert!(told.contains("other.cuts") && told.contains("put them back"), "{told}");
    assert_eq!(
        folder.run("render a.lapidary --env studio --out a.png").status.code(),
        Some(2),
        "looks have their light"
    );
}
