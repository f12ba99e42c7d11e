//! `bake`, `info` and `verify` from end to end.

use crate::common::{Folder, SMALL, contents, keys};
use lapidary_core::dataset::Dataset;

#[test]
fn the_report_has_the_keys_that_scripts_depend_on() {
    let stage = Folder::new();
    stage.bake("a.cuts", "--report report.json");
    let report = stage.json("report.json");
    for key in [
        "vertices",
        "triangles",
        "lights",
        "tree",
        "beta",
        "sigma",
        "mean_cut",
        "max_cut",
        "rms_visibility",
        "bytes_cuts",
        "bytes_total",
        "samples_resolved",
        "rays_traced",
        "samples_per_second",
        "peak_memory_bytes",
        "seconds",
    ] {
        assert!(!report[key].is_null(), "{key}");
    }
    let phases = ["import", "pack", "pilot", "tessellate", "total", "tree", "visibility"];
    assert_eq!(keys(&report["seconds"]), phases);
    assert_eq!((report["lights"].as_u64(), report["tree"].as_str()), (Some(1024), Some("mixed")));
    let samples = report["samples_resolved"].as_u64();
    assert_eq!(samples, report["bake_points"].as_u64().map(|points| 1024 * points));
    let stored = std::fs::metadata(stage.path("a.cuts")).expect("a dataset").len();
    assert!(report["bytes_total"].as_u64().is_some_and(|b| b < stored && b > stored / 2));
}

#[test]
fn info_and_verify_agree_with_the_bake() {
    let stage = Folder::new();
    stage.bake("a.cuts", "");
    assert!(stage.succeed("info a.cuts").contains("light tree 1024 samples"));
    let info: serde_json::Value = serde_json::from_str(&stage.succeed("info a.cuts --json")).expect("JSON");
    assert_eq!(info["report"]["lights"].as_u64(), Some(1024));
    let verified: serde_json::Value =
        serde_json::from_str(&stage.succeed("verify a.cuts --vertices 9999 --json")).expect("JSON");
    assert_eq!(verified["different_cuts"].as_u64(), Some(0));
    assert!(verified["passed"].as_bool() == Some(true) && verified["rms_visibility"].as_f64().is_some_and(|r| r > 0.0));
}

#[test]
fn threads_and_chunks_do_not_change_a_bit_and_settings_do() {
    let stage = Folder::new();
    stage.bake("a.cuts", "--threads 1 --chunks 1");
    stage.bake("b.cuts", "--threads 4 --chunks 9");
    stage.bake("c.cuts", "--sigma 3");
    let [a, b, c] = ["a.cuts", "b.cuts", "c.cuts"].map(|name| contents(&stage.dataset(name)));
    assert!(a == b && a != c);
}

#[test]
fn a_two_triangle_floor_is_tessellated_only_if_asked() {
    let stage = Folder::new();
    stage.bake("a.cuts", "");
    let out = stage.run("bake scene.obj -o b.cuts --lights 256 --no-tessellate --progress none");
    assert!(out.status.success());
    assert!(stage.dataset("a.cuts").scene.mesh.positions.len() > 300);
    assert_eq!(stage.dataset("b.cuts").scene.mesh.triangles.len(), 14);
}

#[test]
fn a_bake_for_a_shot_has_its_vertices_there_whatever_the_threads() {
    let stage = Folder::new();
    // A corner of the floor from above.
    let shot = "--shot 1.2,1.5,1.2:1.2,0,1.1:40:1";
    stage.bake("all.cuts", "");
    stage.bake("one.cuts", &format!("{shot} --threads 1"));
    stage.bake("two.cuts", &format!("{shot} --threads 2"));
    let [all, one, two] = ["all.cuts", "one.cuts", "two.cuts"].map(|name| stage.dataset(name));
    assert!(contents(&one) == contents(&two));
    assert_eq!(one.scene.mesh.positions, two.scene.mesh.positions);
    let in_corner = |dataset: &Dataset| {
        let on_floor = dataset.scene.mesh.positions.iter().filter(|p| p.y == 0.0);
        on_floor.filter(|p| (p.x - 1.2).abs() < 0.5 && (p.z - 1.2).abs() < 0.5).count()
    };
    assert!(in_corner(&one) > 2 * in_corner(&all), "{} and {}", in_corner(&one), in_corner(&all));
    assert_eq!(one.settings.shots.len(), 1);
    let errors = stage.fail(&format!("bake scene.obj -o a.cuts {SMALL} --shot hero"));
    assert!(errors.contains("no camera \"hero\""), "{errors}");
    assert!(stage.succeed("info one.cuts").contains("for        1 shot"));
}

#[test]
fn a_budget_below_the_mesh_is_remarked() {
    let stage = Folder::new();
    let bake = |vertices| stage.run(&format!("bake scene.obj -o a.cuts --lights 256 --max-vertices {vertices}"));
    let errors = |vertices| String::from_utf8_lossy(&bake(vertices).stderr).into_owned();
    assert!(errors(20).contains("no triangle is split"));
    assert!(!errors(400).contains("no triangle is split"), "negative control");
}

/// Ctrl-C leaves a checkpoint and exit code 130; `--resume` gives what an uninterrupted bake gives.
#[test]
#[cfg(unix)]
fn an_interrupted_bake_resumes_to_the_same_bits() {
    let stage = Folder::new();
    let options =
        "bake scene.obj -o a.cuts --lights 32768 --pilot-clusters 16 --max-vertices 3000 --chunks 200 --progress none";
    let mut child = stage.command(options).stderr(std::process::Stdio::null()).spawn().expect("the program starts");
    let first_chunk = stage.path("a.cuts.partial/chunk-00000.bin");
    while !first_chunk.exists() {
        assert!(child.try_wait().expect("a child").is_none(), "the bake ended before it could be interrupted");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.is_ok_and(|s| s.success()));
    assert_eq!(child.wait().expect("a child").code(), Some(130));
    assert!(first_chunk.exists() && !stage.path("a.cuts").exists());
    stage.succeed(&format!("{options} --resume"));
    stage.succeed(&options.replace("a.cuts", "b.cuts"));
    assert!(contents(&stage.dataset("a.cuts")) == contents(&stage.dataset("b.cuts")));
    assert!(!stage.path("a.cuts.partial").exists());
}

#[test]
fn quiet_bakes_print_nothing() {
    let stage = Folder::new();
    let output = stage.run("--quiet bake scene.obj -o a.cuts --lights 256 --no-tessellate");
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn help_teaches_every_command() {
    let stage = Folder::new();
    let help = stage.succeed("--help");
    for command in ["demo", "bake", "info", "verify", "render", "reference", "compare"] {
        assert!(help.contains(command), "{command}");
        assert!(stage.succeed(&format!("{command} --help")).contains("Usage"), "{command}");
    }
    assert!(!help.contains("frobnicate"), "negative control");
}
