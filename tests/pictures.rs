//! `render`, `reference` and `compare` from end to end.

use crate::common::{Folder, keys};
use lapidary_core::image::Image;
use lapidary_interchange::image;

/// Looks down on box and floor.
const VIEW: &str = "--env sun-sky:50 --eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 48x36";

fn baked() -> Folder {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    folder
}

/// Relative RMSE of a picture against another.
fn rel_rmse(folder: &Folder, test: &str, reference: &str) -> f64 {
    folder.succeed(&format!("compare {test} {reference} --json m.json"));
    folder.json("m.json")["rel_rmse"].as_f64().expect("a number")
}

#[test]
fn a_picture_is_close_to_both_references_and_a_turned_one_is_not() {
    let folder = baked();
    folder.succeed(&format!("render a.cuts {VIEW} --backend cpu --out a.exr --out a.png --stats stats.json"));
    let stats = folder.json("stats.json");
    assert_eq!(
        keys(&stats),
        ["adapter", "backend", "mean_brdf_evaluations", "mean_merged_nodes", "pixels_shaded", "seconds", "tier"]
    );
    assert_eq!(stats["backend"].as_str(), Some("cpu"));
    folder.succeed(&format!("reference a.cuts {VIEW} --kind samples --out samples.exr"));
    folder.succeed(&format!("reference a.cuts {VIEW} --kind path --spp 64 --out path.exr"));
    folder.succeed(&format!("render a.cuts {VIEW} --rotate 120 --out turned.exr"));
    let error = |test, reference| rel_rmse(&folder, test, reference);
    let (near, whole, turned) =
        (error("a.exr", "samples.exr"), error("a.exr", "path.exr"), error("turned.exr", "samples.exr"));
    let metrics = folder.json("m.json");
    for key in ["rmse", "rel_rmse", "rel_mse", "psnr", "ssim", "flip"] {
        assert!(metrics[key].is_number(), "{key}");
    }
    assert!(near < 0.2 && whole < 0.3, "{near} and {whole}");
    assert!(turned > 2.0 * near, "negative control: {turned}");
}

#[test]
fn pictures_for_people_have_sixteen_samples_and_those_to_measure_one() {
    let folder = baked();
    let picture = |command: &str, options: &str| {
        // Without the one sample that tests take.
        let line = format!("{command} {VIEW} {options} --out a.exr");
        let mut program = std::process::Command::new(crate::common::LAPIDARY);
        program.args(line.split_whitespace()).current_dir(folder.path(".")).env("XDG_RUNTIME_DIR", folder.path("."));
        assert!(program.status().expect("it starts").success(), "{line}");
        image::read(&folder.path("a.exr")).expect("a picture")
    };
    for (command, samples) in [
        ("render a.cuts --backend cpu", 16),
        ("reference a.cuts --kind path --spp 16", 16),
        ("reference a.cuts --kind samples", 1),
    ] {
        let usual = picture(command, "");
        assert!(usual == picture(command, &format!("--aa {samples}")), "{command}");
        assert!(usual != picture(command, &format!("--aa {}", 17 - samples)), "negative control: {command}");
    }
}

#[test]
fn bounds_decide_the_exit_code_and_maps_are_written() {
    let folder = baked();
    for (name, roughness) in [("a", 0.3), ("b", 0.6)] {
        folder.succeed(&format!("render a.cuts {VIEW} --roughness {roughness} --metalness 1 --out {name}.exr"));
    }
    let code = |bound: &str| folder.run(&format!("compare a.exr b.exr --fail-above {bound}")).status.code();
    assert_eq!((code("rel_rmse=0.0001"), code("rel_rmse=100"), code("nonsense=1")), (Some(3), Some(0), Some(2)));
    for kind in ["rel", "abs", "flip"] {
        folder.succeed(&format!("compare a.exr b.exr --map {kind} --out {kind}.png"));
        let map = image::read(&folder.path(&format!("{kind}.png"))).expect("a map");
        assert!(map.size[0] >= 48 && map.size[1] > 36, "the {kind} map and its legend: {:?}", map.size);
    }
}

#[test]
fn material_options_do_what_files_do_and_twice_the_light_is_twice_the_picture() {
    let folder = baked();
    let parameters = r#""parameters": {"base_color": [1, 0.7, 0.3], "metalness": 1, "roughness": 0.4}"#;
    for model in ["ggx", "ward-duer"] {
        folder.write(&format!("{model}.json"), format!(r#"{{"model": "{model}", {parameters}}}"#));
    }
    for (name, options) in [
        ("own", ""),
        ("option", "--base-color 1,0.7,0.3 --metalness 1 --roughness 0.4 --brdf refine"),
        ("ggx", "--material ggx.json --brdf refine"),
        ("ward", "--material ward-duer.json --brdf refine"),
        ("once", "--brdf once --illum-cut 8"),
        ("bright", "--intensity 2"),
    ] {
        // The figures below are of light samples.
        folder.succeed(&format!("render a.cuts {VIEW} --sun off --no-mirrors {options} --out {name}.exr"));
    }
    let read = |name: &str| image::read(&folder.path(&format!("{name}.exr"))).expect("a picture");
    assert_eq!(read("option"), read("ggx"));
    let error = |test: &str, reference: &str| rel_rmse(&folder, &format!("{test}.exr"), &format!("{reference}.exr"));
    let (ward, once, gold) = (error("ward", "ggx"), error("once", "own"), error("option", "own"));
    // Beside the shape of the lobe this is the sun that rough metal reflects twice, which Ward-Duer lacks.
    assert!((ward - 0.349).abs() < 0.01, "another model: {ward}");
    assert!((once - 0.053).abs() < 0.01, "few nodes: {once}");
    assert!(gold > 0.5, "negative control: {gold}");
    for (bright, own) in read("bright").pixels.iter().zip(&read("own").pixels) {
        assert!((*bright - 2.0 * own).abs().max_element() <= 1e-3 * own.max_element(), "{bright} and {own}");
    }
}

#[test]
fn more_samples_a_pixel_smooth_edges_in_all_renderers_alike() {
    let folder = baked();
    // Of a small picture more is edges.
    let view = VIEW.replace("48x36", "24x18");
    let errors = |sun: &str| {
        folder.succeed(&format!("render a.cuts {view} --sun {sun} --aa 4 --out a.exr"));
        folder.succeed(&format!("reference a.cuts {view} --sun {sun} --aa 4 --out r.exr"));
        folder.succeed(&format!("render a.cuts {view} --sun {sun} --out one.exr"));
        (rel_rmse(&folder, "a.exr", "r.exr"), rel_rmse(&folder, "one.exr", "r.exr"))
    };
    let (same, other) = errors("off");
    assert!(same < 0.064 && other > 0.07, "{same}, and with one sample {other}");
    // A sun is shadowed by rays in both, and most of the light is its.
    let (same, other) = errors("on");
    assert!(same < 0.01 && other > 0.04, "with suns {same}, and with one sample {other}");
}

#[test]
fn the_bundled_still_life_bakes_and_is_rendered_close_to_its_reference() {
    let folder = Folder::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");
    folder.succeed(&format!("bake {data}/still-life/still-life.gltf -o s.cuts --lights 512 --pilot-clusters 32 --no-tessellate --progress none"));
    let view = format!("s.cuts --env {data}/environments/studio.hdr --size 64x48");
    folder.succeed(&format!("render {view} --out s.exr"));
    folder.succeed(&format!("reference {view} --out r.exr"));
    folder.succeed(&format!("render {view} --rotate 120 --out turned.exr"));
    let (near, turned) = (rel_rmse(&folder, "s.exr", "r.exr"), rel_rmse(&folder, "turned.exr", "r.exr"));
    assert!(near < 0.13 && turned > 0.8, "{near}, and turned {turned}");
}

/// A point light 3 m over the floor and a sun at the same place.
const LAMPS: &str = r#"{"lights": [
    {"kind": "point", "position": [0.5, 3, 0.5], "intensity": [9, 8, 6]},
    {"kind": "directional", "position": [1, 2, 1], "target": [0, 0, 0], "intensity": [0.5, 0.5, 0.6]},
    {"kind": "rectangle", "position": [-1, 2, 0], "target": [0, 0, 0], "intensity": [3, 3, 3], "width": 0.5, "height": 0.5}
]}"#;

#[test]
fn lamps_of_a_file_give_the_light_of_the_reference_and_its_components_sum() {
    let folder = baked();
    folder.write("lamps.json", LAMPS.into());
    let view = "--eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 48x36 --lights lamps.json";
    let read = |name: &str| image::read(&folder.path(&format!("{name}.exr"))).expect("a picture");
    let mean = |name: &str| read(name).pixels.iter().map(|p| p.y).sum::<f32>() / (48.0 * 36.0);
    folder.succeed(&format!("render a.cuts {view} --backend cpu --out a.exr"));
    folder.succeed(&format!("reference a.cuts {view} --out samples.exr"));
    folder.succeed(&format!("reference a.cuts {view} --kind path --spp 16 --out path.exr"));
    folder.succeed(&format!("render a.cuts {view} --components environment --env none --out none.exr"));
    assert_eq!(read("a"), read("samples"), "both trace the same rays");
    assert!(mean("a") > 0.1 && (mean("path") / mean("a") - 1.0).abs() < 0.02, "{} {}", mean("path"), mean("a"));
    assert_eq!(mean("none"), 0.0, "negative control: no light without the lamps");
    for (name, options) in [
        ("whole", "--bounces 2"),
        ("direct", "--components direct"),
        ("sky", "--components environment"),
        ("bounced", "--components indirect --bounces 2"),
    ] {
        folder.succeed(&format!(
            "reference a.cuts {view} --env constant:0.3,0.3,0.3 --kind path --spp 64 {options} --out {name}.exr"
        ));
    }
    let sum = mean("direct") + mean("sky") + mean("bounced");
    assert!((sum / mean("whole") - 1.0).abs() < 0.02, "{sum} and {}", mean("whole"));
    assert!(mean("bounced") > 0.01 && mean("sky") > 0.1, "{} {}", mean("bounced"), mean("sky"));
}

#[test]
fn a_bound_below_is_for_metrics_where_larger_is_better() {
    let folder = baked();
    for (name, angle) in [("a", 0), ("b", 90)] {
        folder.succeed(&format!("render a.cuts {VIEW} --rotate {angle} --out {name}.exr"));
    }
    let run = |options: &str| {
        let output = folder.run(&format!("compare a.exr b.exr {options}"));
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(run("--fail-below ssim=0.9999").0, Some(3));
    assert_eq!(run("--fail-below ssim=-1").0, Some(0));
    let (code, hint) = run("--fail-above psnr=1");
    assert!(code == Some(3) && hint.contains("--fail-below psnr=1"), "{hint}");
    assert_eq!(run("--out map.png").0, Some(2), "a map needs its kind");
}

#[test]
fn equal_pictures_have_no_error_and_infinity_becomes_null() {
    let folder = baked();
    folder.succeed(&format!("render a.cuts {VIEW} --out a.exr"));
    folder.succeed("compare a.exr a.exr --json m.json --fail-above rmse=0 --fail-above flip=0 --fail-below ssim=1");
    assert!(folder.json("m.json")["psnr"].is_null());
}

#[test]
fn pixels_that_are_not_finite_are_told_and_left_out() {
    use glam::Vec3;
    let folder = Folder::new();
    let good = Image::filled([16, 16], Vec3::splat(0.5));
    let mut bad = good.clone();
    bad.pixels[7] = Vec3::splat(f32::NAN);
    image::write(&good, &folder.path("good.exr")).expect("a writable folder");
    image::write(&bad, &folder.path("bad.exr")).expect("a writable folder");
    let output = folder.run("compare bad.exr good.exr --json m.json");
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 pixels are not finite"));
    assert_eq!(folder.json("m.json")["rmse"].as_f64(), Some(0.0));
    assert_eq!(folder.run("compare bad.exr good.exr --fail-above non_finite_pixels=0").status.code(), Some(3));
}

#[test]
fn quiet_commands_print_nothing_and_loud_ones_do() {
    let folder = baked();
    for command in [
        format!("render a.cuts {VIEW} --out a.exr"),
        format!("reference a.cuts {VIEW} --out r.exr"),
        "compare a.exr a.exr".into(),
    ] {
        let quiet = folder.run(&format!("--quiet {command}"));
        assert!(quiet.status.success() && quiet.stdout.is_empty() && quiet.stderr.is_empty(), "{command}");
        assert!(!folder.succeed(&command).is_empty(), "negative control: {command}");
    }
}

/// Ctrl-C keeps what there is of a reference.
#[test]
#[cfg(unix)]
fn an_interrupted_reference_writes_its_picture_and_says_so() {
    let folder = baked();
    let options = format!("reference a.cuts {VIEW} --kind path --spp 1000000 --out r.exr --out r.png");
    let mut command = folder.command(&options);
    let child = command.stderr(std::process::Stdio::piped()).spawn().expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.is_ok_and(|s| s.success()));
    let output = child.wait_with_output().expect("a child");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{errors}");
    assert!(errors.contains("unfinished") && errors.contains("r.exr") && !errors.contains("panicked"), "{errors}");
    let picture = image::read(&folder.path("r.exr")).expect("a picture");
    assert!(picture.pixels.iter().any(|p| p.y > 0.0) && folder.path("r.png").exists());
}
