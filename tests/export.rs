//! `render --layers`, `compare --layer` and `sequence` from end to end.

use crate::common::{Folder, files_in, keys};
use glam::Vec3;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use std::{fs, path::Path, time::Duration};

const VIEW: &str = "--eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 40x30 --backend cpu";

const LAMP: &str =
    r#"{"lights": [{"kind": "point", "name": "lamp", "position": [0.6, 2, 0.8], "intensity": [9, 8, 6]}]}"#;

fn baked(more: &str) -> Folder {
    let folder = Folder::new();
    folder.bake("a.cuts", more);
    folder.write("lamp.json", LAMP.into());
    folder
}

fn layer(folder: &Folder, name: &str) -> Image {
    image::read_layer(&folder.path("layers.exr"), name).expect("a layer")
}

fn brightness(image: &Image) -> f32 {
    image.pixels.iter().map(|p| p.element_sum()).sum()
}

/// Sum of the absolute differences over the sum of `b`.
fn distance(a: &Image, b: &Image) -> f32 {
    let difference: f32 = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().element_sum()).sum();
    difference / brightness(b)
}

#[test]
fn parts_of_the_light_sum_to_the_picture_and_a_missing_one_shows() {
    let folder = baked("--mode cuts --sources 1024");
    let view = format!("{VIEW} --env sun-sky:50 --lights lamp.json --aa 4");
    folder.succeed(&format!("render a.cuts {view} --out layers.exr --layers all --out plain.exr"));
    let [beauty, environment, direct, indirect] =
        ["beauty", "environment", "direct", "indirect"].map(|name| layer(&folder, name));
    let mut sum = environment.clone();
    sum.add(&direct);
    let without = distance(&sum, &beauty);
    sum.add(&indirect);
    let with = distance(&sum, &beauty);
    assert!(with < 1e-5, "{with}");
    assert!(without > 1e-3, "negative control: the bounce is {without} of the picture");
    assert_eq!(image::read(&folder.path("plain.exr")).expect("a picture"), beauty);
    for name in ["normal", "albedo", "roughness", "position", "depth", "coverage"] {
        assert!(layer(&folder, name).pixels.iter().all(|p| p.is_finite()), "{name}");
    }
    for name in ["visibility-nodes", "merged-nodes", "brdf-evaluations"] {
        assert!(brightness(&layer(&folder, name)) > 0.0, "{name}");
    }
    assert!(layer(&folder, "coverage").pixels.iter().all(|p| (0.0..=1.0).contains(&p.x)));
}

#[test]
fn compare_finds_layers_and_says_which_there_are() {
    let folder = baked("");
    folder.succeed(&format!("render a.cuts {VIEW} --env studio --out layers.exr --layers normal,depth --out a.png"));
    folder.succeed(&format!("render a.cuts {VIEW} --env studio --out plain.exr"));
    let code = |options: &str| {
        folder.run(&format!("compare layers.exr plain.exr {options} --fail-above rmse=1e-6")).status.code()
    };
    assert_eq!((code(""), code("--layer beauty"), code("--layer normal")), (Some(0), Some(0), Some(3)));
    assert_eq!(
        folder.run("compare layers.exr layers.exr --layer depth --reference-layer depth").status.code(),
        Some(0)
    );
    let message = folder.fail("compare layers.exr plain.exr --layer indirect");
    for word in ["indirect", "RGBA", "normal", "depth", "layers.exr"] {
        assert!(message.contains(word), "{message}");
    }
    assert!(folder.fail("compare a.png plain.exr --layer normal").contains("only exr files have layers"));
}

#[test]
fn layers_that_cannot_be_are_refused() {
    let folder = baked("");
    let message = folder.fail(&format!("render a.cuts {VIEW} --env studio --out a.exr --layers indirect"));
    assert!(message.contains("indirect") && message.contains("--mode"), "{message}");
    assert!(folder.fail(&format!("render a.cuts {VIEW} --out a.png --layers normal")).contains(".exr"));
    let unknown = folder.run(&format!("render a.cuts {VIEW} --out a.exr --layers specular"));
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("brdf-evaluations"), "the list of layers");
    assert!(!folder.path("a.exr").exists() && !folder.path("a.png").exists());
}

#[test]
fn a_sweep_writes_numbered_frames_their_values_and_a_sheet_and_goes_on() {
    let folder = baked("");
    let command = format!(
        "sequence a.cuts {VIEW} --env studio --base-color 0.8 --sweep roughness=0.1..0.9 --frames 4 --out out/f.###.png \
         --out out/f.###.exr --contact-sheet out/sheet.png --columns 2"
    );
    folder.succeed(&command);
    assert_eq!(files_in(&folder.path("out")), 10);
    let record = folder.json("out/f.json");
    assert_eq!(keys(&record), ["frames", "settings", "size"]);
    let value = record["frames"][3]["values"]["roughness"].as_f64().expect("a number");
    assert!((value - 0.9).abs() < 1e-6, "{value}");
    let sheet = lapidary_interchange::image::dimensions(&folder.path("out/sheet.png")).expect("a sheet");
    assert!(sheet[0] > 2 * 40 && sheet[1] > 2 * 30, "{sheet:?}");
    folder.succeed(&format!("render a.cuts {VIEW} --env studio --base-color 0.8 --roughness 0.9 --out alone.exr"));
    let read = |name: &str| image::read(&folder.path(name)).expect("a picture");
    assert!(distance(&read("out/f.004.exr"), &read("alone.exr")) < 1e-6);
    assert!(distance(&read("out/f.001.exr"), &read("alone.exr")) > 1e-3, "negative control");

    let message = folder.fail(&command);
    assert!(message.contains("4 of the 4 frames are there") && message.contains("--resume"), "{message}");
    fs::remove_file(folder.path("out/f.002.exr")).expect("a frame");
    assert!(folder.succeed(&format!("{command} --resume")).contains("1 frames"));
    let message = folder.fail(&format!("{command} --resume --exposure 1"));
    assert!(message.contains("another sequence"), "{message}");
}

#[test]
fn an_object_that_turns_shows_its_other_side_before_the_same_background() {
    let folder = baked("");
    let view = VIEW.replace("--eye 0.5,3,3 --target 0,0.3,0", "--eye 1.5,1.2,4 --target 0,0.3,0");
    folder.succeed(&format!("sequence a.cuts {view} --env sun-sky:40 --turn object --frames 4 --out o/f.#.exr"));
    folder.succeed(&format!("sequence a.cuts {view} --env sun-sky:40 --turn camera --frames 4 --out c/f.#.exr"));
    let frame = |path: &str| image::read(&folder.path(path)).expect("a frame");
    let sky = |image: &Image| image.pixels[..40].to_vec();
    let far = |a: &Image, b: &Image| {
        sky(a).iter().zip(&sky(b)).map(|(a, b)| (*a - *b).length()).fold(0.0f32, f32::max) > 1e-3
    };
    let (first, quarter) = (frame("o/f.1.exr"), frame("o/f.2.exr"));
    assert!(!far(&first, &quarter), "the background stays");
    assert!(distance(&first, &quarter) > 1e-3, "the scene turns");
    assert!(far(&frame("c/f.1.exr"), &frame("c/f.2.exr")), "negative control: before a camera that turns it does not");
    assert_eq!(first, frame("c/f.1.exr"), "both begin with the picture itself");
}

#[test]
fn sequences_that_cannot_be_are_refused_before_anything_is_rendered() {
    let folder = baked("");
    let fail = |options: &str| folder.fail(&format!("sequence a.cuts {VIEW} --env studio {options}"));
    assert!(fail("--turn camera --out frame.png").contains("####"));
    assert!(fail("--out f.##.png").contains("nothing changes"));
    assert!(fail("--turn lights --out f.##.png").contains("no local lights"));
    assert!(fail("--sweep roughness@tin=0..1 --out f.##.png").contains("white"));
    assert!(fail("--turn camera --layers normal --out f.##.png").contains("exr"));
    assert!(fail("--turn camera --out f.##.png --contact-sheet s.jpg").contains(".png"));
    fs::write(folder.path("file"), "").expect("a file");
    assert!(fail("--turn camera --out file/f.##.png").contains("something that is no folder has its name"));
    let wrong = |options: &str| {
        let output = folder.run(&format!("sequence a.cuts {VIEW} {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let message = wrong("--sweep gloss=0..1 --out f.##.png");
    assert!(message.contains("gloss") && message.contains("light-position"), "{message}");
    wrong("--turn camera --frames 0 --out f.##.png");
    wrong("--turn camera --resume --overwrite --out f.##.png");
    wrong("--turn camera");
    assert!(!folder.path("f.01.png").exists() && !folder.path("f.json").exists());
}

#[test]
#[cfg(unix)]
fn an_interrupted_sequence_leaves_whole_frames_and_goes_on() {
    let folder = baked("");
    let command = "sequence a.cuts --eye 0.5,3,3 --target 0,0.3,0 --size 160x120 --backend cpu --env studio --turn object \
                   --frames 60 --out out/f.##.png";
    let mut child = folder.command(command).spawn().expect("the program starts");
    wait_for(&folder.path("out/f.02.png"));
    let signal = format!("kill -INT {}", child.id());
    std::process::Command::new("sh").args(["-c", &signal]).status().expect("a signal");
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    let there = fs::read_dir(folder.path("out")).expect("a folder").filter_map(|f| Some(f.ok()?.file_name()));
    let pictures: Vec<String> =
        there.filter_map(|name| name.into_string().ok()).filter(|name| name.ends_with(".png")).collect();
    assert!((2..60).contains(&pictures.len()), "{pictures:?}");
    for name in &pictures {
        assert_eq!(image::read(&folder.path("out").join(name)).expect("a whole frame").size, [160, 120]);
    }
    assert!(folder.succeed(&format!("{command} --resume")).contains(&format!("{} were there", pictures.len())));
}

#[cfg(unix)]
fn wait_for(path: &Path) {
    for _ in 0..3000 {
        if path.exists() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("waited in vain for {}", path.display());
}

#[test]
fn exposure_brightens_png_files_and_leaves_scene_linear_ones() {
    let folder = baked("");
    folder.succeed(&format!("render a.cuts {VIEW} --env studio --brdf refine --out a.exr --out a.png"));
    folder.succeed(&format!("render a.cuts {VIEW} --env studio --brdf refine --exposure -1 --out b.exr --out b.png"));
    let read = |name: &str| image::read(&folder.path(name)).expect("a picture");
    assert_eq!(read("a.exr"), read("b.exr"));
    let (a, b) = (read("a.png"), read("b.png"));
    let unclipped = |p: &&Vec3| p.max_element() < 0.9 && p.min_element() > 0.05;
    let place = a.pixels.iter().position(|p| unclipped(&p)).expect("a gray pixel");
    let ratio = a.pixels[place] / b.pixels[place];
    assert!((ratio - 2.0).abs().max_element() < 0.1, "{ratio}");
}
