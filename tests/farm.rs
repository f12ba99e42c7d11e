//! The files in `farm/`: the template by the reference command line of Open Job Description, the scripts by Slurm. Both are
//! skipped aloud where they are not there. `LAPIDARY_PYTHON` names a Python with `openjd-cli`.

use crate::common::{Folder, LAPIDARY, SMALL};
use std::{
    fs,
    path::PathBuf,
    process::{Command, Output},
};

const FARM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../farm");

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// A folder with the dataset that one bake makes.
fn with_whole(options: &str) -> (Folder, Vec<u8>) {
    let folder = Folder::new();
    folder.succeed(&format!("bake scene.obj -o whole.cuts {options} --progress none"));
    let whole = fs::read(folder.path("whole.cuts")).expect("a dataset");
    (folder, whole)
}

/// Runs a script of `farm/` as Slurm does, with its variables.
fn script(folder: &Folder, name: &str, variables: &[(&str, &str)], args: &[&str]) -> Output {
    let mut command = Command::new("bash");
    command.arg(PathBuf::from(FARM).join(name)).args(args).current_dir(folder.path("."));
    command.env("LAPIDARY", LAPIDARY).envs(variables.iter().copied()).output().expect("bash starts")
}

#[test]
fn the_scripts_bake_shards_as_tasks_of_an_array_and_merge_them() {
    let (folder, whole) = with_whole(SMALL.trim_end_matches(" --progress none"));
    let options: Vec<&str> = SMALL.trim_end_matches(" --progress none").split(' ').collect();
    let args = [&["scene.obj", "a.cuts"], &options[..]].concat();
    let task = |id, more: &[(&str, &str)]| {
        let of_task = [("SLURM_ARRAY_TASK_ID", id), ("SLURM_ARRAY_TASK_MAX", "3"), ("SLURM_CPUS_PER_TASK", "2")];
        script(&folder, "bake.slurm", &[&of_task, more].concat(), &args)
    };
    for id in ["1", "3"] {
        let output = task(id, &[("SLURM_ARRAY_TASK_COUNT", "3")]);
        assert!(output.status.success(), "{}", said(&output));
    }
    let early = script(&folder, "merge.slurm", &[], &["a.cuts"]);
    assert!(!early.status.success() && said(&early).contains("--shard 2/3"), "{}", said(&early));
    // An array of one task alone does not say of how many shards it is.
    let few = [("SLURM_ARRAY_TASK_COUNT", "1")];
    let output = task("2", &few);
    assert!(!output.status.success() && said(&output).contains("set SHARDS=N"), "{}", said(&output));
    let output = task("2", &[few[0], ("SHARDS", "3")]);
    assert!(output.status.success(), "{}", said(&output));
    let merged = script(&folder, "merge.slurm", &[], &["a.cuts"]);
    assert!(merged.status.success(), "{}", said(&merged));
    assert!(fs::read(folder.path("a.cuts")).expect("a dataset") == whole, "equal bakes are equal files");
    for name in ["bake.slurm", "merge.slurm"] {
        let output = script(&folder, name, &[], &[]);
        assert!(output.status.code() == Some(2) && said(&output).contains("usage: sbatch"), "{}", said(&output));
    }
}

#[test]
fn a_share_has_no_report_and_shards_that_are_none_are_refused() {
    let folder = Folder::new();
    for (options, reason) in [("--shard 3/2", "as in 3/8"), ("--shard 1/2 --report a.json", "cannot be used with")] {
        let output = folder.run(&format!("bake scene.obj -o a.cuts {SMALL} {options}"));
        assert!(output.status.code() == Some(2) && said(&output).contains(reason), "{}", said(&output));
    }
    let output = folder.run("merge a.cuts");
    assert!(output.status.code() == Some(1) && said(&output).contains("bake them first"), "{}", said(&output));
}

#[test]
fn the_template_runs_on_the_reference_worker_of_open_job_description() {
    let python = std::env::var_os("LAPIDARY_PYTHON").unwrap_or("python3".into());
    let openjd = PathBuf::from(python).with_file_name("openjd");
    if !Command::new(&openjd).arg("--help").output().is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: there is no openjd beside the Python of LAPIDARY_PYTHON; pip install openjd-cli");
        return;
    }
    let (folder, whole) = with_whole("--preset draft");
    let mut command = Command::new(openjd);
    command.args(["run", "--step", "Merge", "--run-dependencies"]).arg(PathBuf::from(FARM).join("bake.yaml"));
    for parameter in [
        format!("Scene={}", folder.path("scene.obj").display()),
        format!("Output={}", folder.path("a.cuts").display()),
        format!("Lapidary={LAPIDARY}"),
        "Shards=3".into(),
        "Preset=draft".into(),
    ] {
        command.args(["-p", &parameter]);
    }
    let output = command.output().expect("openjd starts");
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("openjd_status: visibility") && text.contains("openjd_progress: 9"), "{text}");
    assert!(fs::read(folder.path("a.cuts")).expect("a dataset") == whole, "equal bakes are equal files");
}

#[test]
fn slurm_runs_an_array_and_merges_when_it_has_succeeded() {
    if !Command::new("sinfo").output().is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: there is no Slurm that answers here");
        return;
    }
    let (folder, whole) = with_whole("--preset draft");
    let submit = |args: &[&str]| {
        let mut command = Command::new("sbatch");
        command.args(["--parsable", "--cpus-per-task=1", "--mem=0"]).args(args);
        let output = command.current_dir(folder.path(".")).env("LAPIDARY", LAPIDARY).output().expect("sbatch starts");
        assert!(output.status.success(), "{}", said(&output));
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    };
    let [bake, merge] = ["bake.slurm", "merge.slurm"].map(|name| format!("{FARM}/{name}"));
    let job = submit(&["--array=1-3", &bake, "scene.obj", "a.cuts", "--preset", "draft"]);
    submit(&["--wait", &format!("--dependency=afterok:{job}"), &merge, "a.cuts"]);
    assert!(fs::read(folder.path("a.cuts")).expect("a dataset") == whole, "equal bakes are equal files");
}
