//! `bake`, `info` and `verify` from end to end.

use crate::common::{Folder, SMALL, contents, keys};
use lapidary_core::dataset::Dataset;

#[test]
fn the_report_has_the_keys_that_scripts_depend_on() {
    let folder = Folder::new();
    folder.bake("a.cuts", "--report report.json");
    let report = folder.json("report.json");
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
    let stored = std::fs::metadata(folder.path("a.cuts")).expect("a dataset").len();
    let memory = ["peak_memory_bytes", "estimated_memory_bytes"].map(|key| report[key].as_u64().expect("bytes"));
    assert!(memory[0] <= memory[1] && memory[1] < 4 * memory[0], "{memory:?}");
    assert!(report["bytes_total"].as_u64().is_some_and(|b| b < stored && b > stored / 2));
}

#[test]
fn info_and_verify_agree_with_the_bake() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    assert!(folder.succeed("info a.cuts").contains("light tree 1024 samples"));
    let info: serde_json::Value = serde_json::from_str(&folder.succeed("info a.cuts --json")).expect("JSON");
    assert_eq!(info["report"]["lights"].as_u64(), Some(1024));
    let verified: serde_json::Value =
        serde_json::from_str(&folder.succeed("verify a.cuts --vertices 9999 --json")).expect("JSON");
    assert_eq!(verified["different_cuts"].as_u64(), Some(0));
    assert!(verified["passed"].as_bool() == Some(true) && verified["rms_visibility"].as_f64().is_some_and(|r| r > 0.0));
}

#[test]
fn threads_and_chunks_do_not_change_a_bit_and_settings_do() {
    let folder = Folder::new();
    folder.bake("a.cuts", "--threads 1 --chunks 1");
    folder.bake("b.cuts", "--threads 4 --chunks 9");
    folder.bake("c.cuts", "--sigma 3");
    let [a, b, c] = ["a.cuts", "b.cuts", "c.cuts"].map(|name| std::fs::read(folder.path(name)).expect("a dataset"));
    assert!(a == b && a != c, "equal bakes are equal files");
}

#[test]
fn a_two_triangle_floor_is_tessellated_only_if_asked() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let out = folder.run("bake scene.obj -o b.cuts --lights 256 --no-tessellate --progress none");
    assert!(out.status.success());
    assert!(folder.dataset("a.cuts").scene.mesh.positions.len() > 300);
    assert_eq!(folder.dataset("b.cuts").scene.mesh.triangles.len(), 14);
}

#[test]
fn a_bake_for_a_shot_has_its_vertices_there_whatever_the_threads() {
    let folder = Folder::new();
    // A corner of the floor from above.
    let shot = "--shot 1.2,1.5,1.2:1.2,0,1.1:40:1";
    folder.bake("all.cuts", "");
    folder.bake("one.cuts", &format!("{shot} --threads 1"));
    folder.bake("two.cuts", &format!("{shot} --threads 2"));
    let [all, one, two] = ["all.cuts", "one.cuts", "two.cuts"].map(|name| folder.dataset(name));
    assert!(contents(&one) == contents(&two));
    assert_eq!(one.scene.mesh.positions, two.scene.mesh.positions);
    let in_corner = |dataset: &Dataset| {
        let on_floor = dataset.scene.mesh.positions.iter().filter(|p| p.y == 0.0);
        on_floor.filter(|p| (p.x - 1.2).abs() < 0.5 && (p.z - 1.2).abs() < 0.5).count()
    };
    assert!(in_corner(&one) > 2 * in_corner(&all), "{} and {}", in_corner(&one), in_corner(&all));
    assert_eq!(one.settings.shots.len(), 1);
    let errors = folder.fail(&format!("bake scene.obj -o a.cuts {SMALL} --shot hero"));
    assert!(errors.contains("no camera \"hero\""), "{errors}");
    assert!(folder.succeed("info one.cuts").contains("for        1 shot"));
}

#[test]
fn a_budget_below_the_mesh_is_remarked() {
    let folder = Folder::new();
    let bake = |vertices| folder.run(&format!("bake scene.obj -o a.cuts --lights 256 --max-vertices {vertices}"));
    let errors = |vertices| String::from_utf8_lossy(&bake(vertices).stderr).into_owned();
    assert!(errors(20).contains("no triangle is split"));
    assert!(!errors(400).contains("no triangle is split"), "negative control");
}

/// Ctrl-C leaves a checkpoint and exit code 130; `--resume` gives what an uninterrupted bake gives.
#[test]
#[cfg(unix)]
fn an_interrupted_bake_resumes_to_the_same_bits() {
    let folder = Folder::new();
    let options =
        "bake scene.obj -o a.cuts --lights 32768 --pilot-clusters 16 --max-vertices 3000 --chunks 200 --progress none";
    let mut child = folder.command(options).stderr(std::process::Stdio::null()).spawn().expect("the program starts");
    let first_chunk = folder.path("a.cuts.partial/chunk-00000.bin");
    while !first_chunk.exists() {
        assert!(child.try_wait().expect("a child").is_none(), "the bake ended before it could be interrupted");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.is_ok_and(|s| s.success()));
    assert_eq!(child.wait().expect("a child").code(), Some(130));
    assert!(first_chunk.exists() && !folder.path("a.cuts").exists());
    folder.succeed(&format!("{options} --resume"));
    folder.succeed(&options.replace("a.cuts", "b.cuts"));
    assert!(contents(&folder.dataset("a.cuts")) == contents(&folder.dataset("b.cuts")));
    assert!(!folder.path("a.cuts.partial").exists());
}

#[test]
fn quiet_bakes_print_nothing() {
    let folder = Folder::new();
    let output = folder.run("--quiet bake scene.obj -o a.cuts --lights 256 --no-tessellate");
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn help_teaches_every_command() {
    let folder = Folder::new();
    let help = folder.succeed("--help");
    for command in ["demo", "bake", "info", "verify", "check", "render", "reference", "compare"] {
        assert!(help.contains(command), "{command}");
        assert!(folder.succeed(&format!("{command} --help")).contains("Usage"), "{command}");
    }
    assert!(!help.contains("frobnicate"), "negative control");
}
