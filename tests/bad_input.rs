//! Bad input gets a message that names the file and says what to do; nothing good is lost.

use crate::common::{Folder, SMALL, files_in};
use lapidary_interchange::image;
use std::fs;

#[test]
fn damaged_and_foreign_datasets_are_refused() {
    let folder = Folder::new();
    folder.bake("good.cuts", "");
    let bytes = fs::read(folder.path("good.cuts")).expect("a dataset");
    for (name, contents) in [
        ("short.cuts", bytes[..bytes.len() / 2].to_vec()),
        ("empty.cuts", Vec::new()),
        ("foreign.cuts", fs::read(folder.path("scene.obj")).expect("the scene")),
        ("flipped.cuts", bytes.iter().enumerate().map(|(i, b)| b ^ u8::from(i == bytes.len() - 100)).collect()),
    ] {
        fs::write(folder.path(name), contents).expect("a writable folder");
        for command in
            [format!("info {name}"), format!("verify {name}"), format!("render {name} --env studio --out a.png")]
        {
            let message = folder.fail(&command);
            assert!(message.contains("bake") && message.contains(name), "{command}: {message}");
        }
    }
    assert!(!folder.path("a.png").exists());
    folder.succeed("info good.cuts");
}

#[test]
fn damaged_scenes_are_refused_by_name() {
    let folder = Folder::new();
    for (name, text) in [
        ("nan.obj", "v 0 0 0\nv nan 0 1\nv 1 0 0\nf 1 2 3\n"),
        ("index.obj", "v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 9\n"),
        ("empty.obj", "# nothing\n"),
        ("points.obj", "v 0 0 0\nv 0 0 1\n"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
        ("broken.gltf", "{\"asset\": {\"version\": \"2.0\""),
        ("broken.glb", "glTF but not really"),
        ("broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n"),
        ("scene.fbx", "anything"),
    ] {
        folder.write(name, text.into());
        let message = folder.fail(&format!("bake {name} -o a.cuts --progress none"));
        assert!(message.contains(name), "{name}: {message}");
    }
    assert!(folder.fail("bake missing.obj -o a.cuts").contains("missing.obj"));
    assert!(!folder.path("a.cuts").exists());
}

#[test]
fn missing_materials_and_zero_area_triangles_are_warnings() {
    let folder = Folder::new();
    let scene = fs::read_to_string(folder.path("scene.obj")).expect("the scene");
    folder.write("poor.obj", scene.replace("scene.mtl", "gone.mtl") + "f 1 1 2\n");
    let warnings = |options: &str| {
        let small = SMALL.replace("--progress none", "");
        let output = folder.run(&format!("bake poor.obj -o a.cuts {small} --report r.json {options}"));
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{options}: {errors}");
        errors
    };
    for progress in ["bar", "json", "none"] {
        let warnings = warnings(&format!("--progress {progress}"));
        assert_eq!(warnings.matches("gone.mtl").count(), 1, "{progress}: {warnings}");
    }
    assert_eq!(warnings("--progress none --quiet"), "", "negative control");
    assert!(folder.json("r.json")["warnings"].to_string().contains("gone.mtl"));
    assert_eq!(folder.dataset("a.cuts").scene.objects.len(), 2);
}

#[test]
fn environments_that_are_no_radiance_are_repaired_aloud_or_refused() {
    use glam::Vec3;
    use lapidary_core::image::Image;
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let map = Image::from_fn([8, 4], |x, _| match x {
        0 => Vec3::splat(-1.0),
        1 => Vec3::splat(f32::NAN),
        _ => Vec3::ONE,
    });
    image::write(&map, &folder.path("odd.exr")).expect("a writable folder");
    let output = folder.run("render a.cuts --env odd.exr --size 16x12 --out a.exr");
    let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && warnings.contains("negative") && warnings.contains("not numbers"), "{warnings}");
    let picture = image::read(&folder.path("a.exr")).expect("a picture");
    assert!(picture.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
    let exr = fs::read(folder.path("odd.exr")).expect("the map");
    fs::write(folder.path("short.exr"), &exr[..exr.len() / 2]).expect("a writable folder");
    folder.write("foreign.hdr", "not a picture".into());
    for name in ["short.exr", "foreign.hdr", "missing.hdr"] {
        assert!(folder.fail(&format!("render a.cuts --env {name} --out b.exr")).contains(name), "{name}");
    }
    assert!(!folder.path("b.exr").exists());
}

#[test]
fn impossible_options_are_refused_before_any_work() {
    let folder = Folder::new();
    for (options, word) in [
        ("--lights 1000", "power of two"),
        ("--beta 2", "--beta"),
        ("--sigma nan", "--sigma"),
        ("--max-vertices 99999999", "memory"),
    ] {
        let output = folder.run(&format!("bake scene.obj -o a.cuts {options}"));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(word), "{options}: {message}");
    }
    folder.bake("a.cuts", "");
    for options in [
        "--size 0x5 --out a.png",
        "--out a.gif",
        "--roughness 7 --out a.png",
        "--fov 0 --out a.png",
        "--backend abacus --out a.png",
        "--eye 1,2 --out a.png",
        "--eye 1,2,3 --out a.png",
        "--target 1,2,3 --out a.png",
        "--eye 1,2,3 --target 1,2,3 --out a.png",
        "--camera main --out a.png",
        "--base-color 2,0,0 --out a.png",
        "--roughness 0.1 --material m.json --out a.png",
        "--material missing.json --out a.png",
        "--aa 0 --out a.png",
        "--size 32768x32768 --out a.png",
    ] {
        let output = folder.run(&format!("render a.cuts --env studio {options}"));
        assert!(matches!(output.status.code(), Some(1 | 2)), "{options}");
        assert!(!output.stderr.is_empty());
    }
    assert!(!folder.path("a.png").exists() && !folder.path("a.gif").exists());
}

#[test]
fn lights_that_cannot_shine_are_refused_by_name() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let one = |inner: &str| format!(r#"{{"lights": [{{{inner}, "position": [0, 1, 0], "intensity": [1, 1, 1]}}]}}"#);
    let many = vec![r#"{"kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1]}"#; 5000].join(",");
    for (text, word) in [
        ("{".to_owned(), "line 1"),
        ("{\"lamps\": []}".into(), "list of lights"),
        (one(r#""kind": "sun""#), "rectangle"),
        (one(r#""kind": "spot", "target": [0, 0, 0], "cone_degrees": 120"#), "120"),
        (one(r#""kind": "directional", "target": [0, 1, 0]"#), "position"),
        (one(r#""kind": "rectangle", "target": [0, 0, 0], "width": 0, "height": 1"#), "area"),
        (format!(r#"{{"lights": [{many}]}}"#), "5000"),
    ] {
        folder.write("lamps.json", text);
        for command in ["render", "reference"] {
            let message = folder.fail(&format!("{command} a.cuts --lights lamps.json --size 8x6 --out a.png"));
            assert!(message.contains(word) && message.contains("lamps.json"), "{message}");
        }
    }
    assert!(folder.fail("render a.cuts --lights missing.json --size 8x6 --out a.png").contains("missing.json"));
    for (options, mode) in [
        ("--components indirect", "--mode cuts"),
        ("--solution cuts", "--mode cuts"),
        ("--solution meshless", "--mode environment,meshless"),
        ("--solution cuts+meshless", "--mode all"),
    ] {
        let message = folder.fail(&format!("render a.cuts {options} --size 8x6 --out a.png"));
        assert!(message.contains(mode), "{options}: {message}");
    }
    for (options, remedy) in
        [("--bounces 1", "--kind path"), ("--components indirect", "--mode cuts"), ("--spp 4", "--kind path")]
    {
        let message = folder.fail(&format!("reference a.cuts {options} --size 8x6 --out a.png"));
        assert!(message.contains(remedy), "{options}: {message}");
    }
    let message = folder.fail("bounces a.cuts --size 8x6 --out bounces");
    assert!(message.contains("--mode indirect"), "{message}");
    for options in ["--components sun", "--components", "--solution magic", "--kind path --bounces -1"] {
        let output = folder.run(&format!("reference a.cuts {options} --size 8x6 --out a.png"));
        assert_eq!(output.status.code(), Some(2), "{options}");
    }
    assert!(!folder.path("a.png").exists());
    // Inside a wall, or shining on nothing: dark, and no failure.
    folder.write("lamps.json", one(r#""kind": "point", "name": "buried""#).replace("[0, 1, 0]", "[0, 0.75, 0]"));
    for command in ["render", "reference"] {
        let output = folder.run(&format!("{command} a.cuts --lights lamps.json --size 8x6 --out a.exr"));
        let warning = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && warning.contains("\"buried\""), "{warning}");
    }
}

#[test]
fn an_output_that_cannot_be_written_keeps_what_was_there() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    fs::create_dir(folder.path("folder")).expect("a writable folder");
    assert!(folder.fail("bake scene.obj -o gone/a.cuts --progress none").contains("gone"));
    assert!(folder.fail("render a.cuts --env studio --size 8x6 --out gone/a.png").contains("gone"));
    folder.fail("render a.cuts --env studio --size 8x6 --out folder");
    assert_eq!(files_in(&folder.path("folder")), 0);
    folder.succeed("info a.cuts");
}

#[test]
fn outputs_are_checked_before_the_work() {
    let folder = Folder::new();
    folder.write("not-even-a-dataset.cuts", String::new());
    let early = folder.fail("render not-even-a-dataset.cuts --env studio --out a.gif");
    assert!(early.contains(".exr") && early.contains("a.gif"), "{early}");
    let late = folder.fail("render not-even-a-dataset.cuts --env studio --out a.png");
    assert!(late.contains("not-even-a-dataset.cuts"), "negative control: {late}");
}

#[test]
fn pictures_that_cannot_be_compared_are_refused() {
    use glam::Vec3;
    use lapidary_core::image::Image;
    let folder = Folder::new();
    for (name, size) in [("a.exr", [8, 6]), ("b.exr", [6, 8])] {
        image::write(&Image::filled(size, Vec3::ONE), &folder.path(name)).expect("a writable folder");
    }
    let message = folder.fail("compare a.exr b.exr");
    assert!(message.contains("8 x 6") && message.contains("6 x 8"), "{message}");
    assert!(folder.fail("compare a.exr missing.exr").contains("missing.exr"));
    assert!(folder.fail("compare scene.obj a.exr").contains("scene.obj"));
    assert!(folder.fail("compare a.exr a.exr --json gone/m.json").contains("gone"));
}

#[test]
fn a_checkpoint_of_other_settings_is_not_resumed() {
    let folder = Folder::new();
    fs::create_dir(folder.path("a.cuts.partial")).expect("a writable folder");
    folder.write("a.cuts.partial/bake.json", "{}".into());
    let message = folder.fail(&format!("bake scene.obj -o a.cuts {SMALL} --resume"));
    assert!(message.contains("--resume") && message.contains("a.cuts.partial"), "{message}");
    folder.bake("a.cuts", "");
}

#[test]
fn the_demonstration_needs_its_data() {
    let folder = Folder::new();
    let message = folder.fail("demo --data nowhere");
    assert!(message.contains("LAPIDARY_DATA") && message.contains("nowhere"), "{message}");
    assert!(!folder.path("out").exists());
}

/// Standard output that is full, as when redirected to a full disk.
#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_an_error() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let output = folder.command("info a.cuts").stdout(full).output().expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("standard output") && !message.contains("panicked"), "{message}");
}

/// A file system of half a megabyte, where one can be mounted.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_keeps_the_old_dataset_and_says_so() {
    use std::process::Command;
    let folder = Folder::new();
    let disk = folder.path("disk");
    fs::create_dir(&disk).expect("a writable folder");
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=512k", "tmpfs"]).arg(&disk).output();
    if !mount.is_ok_and(|o| o.status.success()) {
        eprintln!("SKIPPED: a small file system cannot be mounted here");
        return;
    }
    let old = "what was there";
    fs::write(disk.join("a.cuts"), old).expect("a writable disk");
    let output = folder.run("bake scene.obj -o disk/a.cuts --lights 8192 --pilot-clusters 16 --max-vertices 6000 --sigma 0.5 --progress none");
    let kept = fs::read_to_string(disk.join("a.cuts")).unwrap_or_default();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let unmounted = Command::new("umount").arg(&disk).status();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("space") && message.contains("a.cuts"), "{message}");
    assert_eq!(kept, old);
    assert!(unmounted.is_ok_and(|s| s.success()));
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_display_the_editor_says_what_to_do() {
    let folder = Folder::new();
    for options in ["", "edit", "edit scene.obj"] {
        let mut command = folder.command(options);
        for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(variable);
        }
        let output = command.env("LAPIDARY_HOME", folder.path("home")).output().expect("the program starts");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{options}: {errors}");
        assert!(errors.contains("set DISPLAY") && errors.contains("lapidary render"), "{options}: {errors}");
    }
}

#[test]
fn a_file_that_is_no_program_is_told_before_anything_is_measured() {
    let folder = Folder::new();
    for other in ["gone", "scene.obj"] {
        let message = folder.fail(&format!("bench --against {other} --json new.json"));
        assert!(message.contains("name a program of lapidary") && message.contains(other), "{message}");
    }
    assert!(folder.fail("bench --against gone --data nowhere").contains("nowhere"));
    assert!(!folder.path("new.json").exists());
}
