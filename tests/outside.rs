//! What a scene or a material names outside its folder is read only if the command line allows it; whatever a file does
//! wrong is told with its name.

use crate::common::{Folder, SMALL};
use glam::Vec3;
use lapidary_core::image::Image;
use lapidary_interchange::image::encode_png;
use std::fs;

/// A folder with a scene in a folder of its own, whose texture is above that.
fn place() -> Folder {
    let folder = Folder::new();
    fs::create_dir(folder.path("scene")).expect("a writable folder");
    fs::write(folder.path("red.png"), encode_png(&Image::filled([4, 4], Vec3::X))).expect("a writable folder");
    let obj = fs::read_to_string(folder.path("scene.obj")).expect("the scene");
    folder.write("scene/scene.obj", obj);
    folder.write("scene/scene.mtl", "newmtl white\nmap_Kd ../red.png\n".into());
    folder
}

#[test]
fn nothing_outside_is_embedded_unnoticed() {
    let folder = place();
    for (option, size) in [("", [8, 8]), ("--allow-outside", [4, 4])] {
        let quiet_bar = SMALL.replace("--progress none", "--progress bar");
        let output = folder.run(&format!("bake scene/scene.obj -o a.cuts {quiet_bar} {option}"));
        let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && warnings.contains("\"../red.png\" are outside"), "{option}: {warnings}");
        let dataset = folder.dataset("a.cuts");
        assert_eq!(dataset.scene.textures[0].size, size, "the chequerboard, or the picture");
        let report = dataset.report.warnings.join("\n");
        assert!(report.contains("\"../red.png\" are outside"), "{report}");
        assert_eq!(report.contains("or allow files outside the folder"), option.is_empty());
    }
}

#[test]
fn a_material_reads_pictures_outside_only_if_allowed() {
    let folder = place();
    folder.bake("a.cuts", "");
    folder.write("scene/x.json", r#"{"maps": {"base_color": {"file": "../red.png"}}}"#.into());
    let render = "render a.cuts --material scene/x.json --size 16x12 --backend cpu --out";
    let message = folder.fail(&format!("{render} a.png"));
    for part in ["../red.png", "or allow files outside the folder", "x.json)"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!folder.path("a.png").exists());
    let output = folder.run(&format!("{render} a.png --allow-outside"));
    let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && warnings.contains("../red.png"), "{warnings}");
}

#[test]
fn names_that_are_no_files_are_told_with_the_material() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    folder.write("text.png", "no picture".into());
    for name in ["data:,", "\\u0000", "gone.png", "text.png"] {
        folder.write("x.json", format!(r#"{{"maps": {{"bump": {{"file": "{name}"}}}}}}"#));
        for command in ["render a.cuts --out a.png", "reference a.cuts --kind samples --out a.png"] {
            let message = folder.fail(&format!("{command} --material x.json --size 8x6"));
            assert!(message.trim_end().ends_with("(x.json)"), "{message}");
            assert!(name.starts_with('\\') || message.contains(name), "{message}");
        }
    }
}

#[test]
fn scenes_of_an_extreme_scale_are_told_with_their_file() {
    let folder = Folder::new();
    let obj = fs::read_to_string(folder.path("scene.obj")).expect("the scene");
    for (name, factor) in [("far.obj", 1e12), ("tiny.obj", 1e-45)] {
        let scaled = |word: &str| word.parse::<f64>().map_or(word.to_owned(), |x| (x * factor).to_string());
        let line = |line: &str| match line.strip_prefix("v ") {
            Some(numbers) => format!("v {}", numbers.split(' ').map(scaled).collect::<Vec<_>>().join(" ")),
            None => line.to_owned(),
        };
        folder.write(name, obj.lines().map(line).collect::<Vec<_>>().join("\n"));
        for mode in ["environment", "indirect", "meshless"] {
            let message = folder.fail(&format!("bake {name} -o a.cuts {SMALL} --mode {mode}"));
            assert!(message.contains("scale the scene") && message.contains(&format!("({name})")), "{message}");
        }
    }
    // Errors of the bake itself name the scene, too.
    let message = folder.fail(&format!("bake scene.obj -o a.cuts {SMALL} --mode indirect --viewpoint 0,0.75,0"));
    assert!(message.contains("(scene.obj)"), "{message}");
    assert!(!folder.path("a.cuts").exists());
}

#[test]
#[cfg(unix)]
fn devices_and_pipes_are_refused_at_once() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let link = |name: &str| {
        std::os::unix::fs::symlink("/dev/zero", folder.path(name)).expect("a writable folder");
        name.to_owned()
    };
    let [scene, dataset, material] = ["zero.gltf", "zero.cuts", "zero.json"].map(link);
    link("zero.hdr");
    for (command, name) in [
        (format!("bake {scene} -o b.cuts"), scene),
        (format!("info {dataset}"), dataset),
        (format!("render a.cuts --material {material} --out a.png"), material.clone()),
        (format!("render a.cuts --lights {material} --out a.png"), material),
        ("render a.cuts --env zero.hdr --out a.png".into(), "zero.hdr".into()),
    ] {
        let message = folder.fail(&command);
        assert!(message.contains("device") && message.contains(&name), "{command}: {message}");
    }
}
