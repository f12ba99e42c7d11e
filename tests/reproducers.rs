//! Inputs that once crashed, hung, or gave something else than they should, run by their command lines.

use crate::common::{Folder, copy_folder};
use lapidary_core::{dataset::Dataset, image::Image};
use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

/// Seconds after which a command counts as hanging; the slowest takes one in a debug build.
const MOST_SECS: f64 = 20.0;

/// Runs a command; how it ended and its standard error.
fn run(command: &mut Command, errors: &Path) -> Result<(Option<i32>, String), String> {
    let file = fs::File::create(errors).expect("a writable folder");
    let began = Instant::now();
    let mut child = command.stdout(Stdio::null()).stderr(file).spawn().expect("the program starts");
    loop {
        if let Some(status) = child.try_wait().expect("a child") {
            let text = fs::read_to_string(errors).expect("standard error");
            return Ok((status.code(), text));
        }
        if began.elapsed().as_secs_f64() > MOST_SECS {
            child.kill().and_then(|()| child.wait()).expect("a child");
            return Err(format!("it takes longer than {MOST_SECS} s"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// What is wrong with how Lapidary takes an input: a crash, a hang, an error that does not name the file, or a result
/// that cannot be read or is not finite.
fn fault(reproducer: &Path) -> Option<String> {
    let folder = Folder::new();
    copy_folder(reproducer, &folder.path("")).expect("a writable folder");
    if folder.path("snap").exists() {
        fs::rename(folder.path("snap"), folder.path("c.cuts.partial")).expect("a writable folder");
    }
    let commands = fs::read_to_string(reproducer.join("commands.txt")).expect("the commands");
    for options in commands.lines() {
        let (code, errors) = match run(&mut folder.command(options), &folder.path("standard-error")) {
            Ok(ended) => ended,
            Err(hangs) => return Some(hangs),
        };
        let names_input =
            |text: &str| ["x.obj", "x.gltf", "x.glb", "x.cuts", "x.json", "c.cuts"].iter().any(|x| text.contains(x));
        match code {
            Some(0) => {}
            Some(1) if errors.contains("error: ") && names_input(&errors) => return None,
            _ => return Some(format!("{options}: exit code {code:?}: {errors}")),
        }
    }
    results_of(&folder)
}

/// Datasets must be read, pictures must be finite.
fn results_of(folder: &Folder) -> Option<String> {
    for entry in fs::read_dir(folder.path("")).expect("a folder").flatten() {
        let path = entry.path();
        let problem = match path.extension().and_then(|extension| extension.to_str()) {
            Some("cuts") => Dataset::read(&path).err().map(|error| error.to_string()),
            Some("exr") => match Image::read(&path) {
                Ok(image) => image.pixels.iter().any(|p| !p.is_finite()).then(|| "it is not finite".into()),
                Err(error) => Some(error.to_string()),
            },
            _ => None,
        };
        if problem.is_some() {
            return problem.map(|problem| format!("{}: {problem}", path.display()));
        }
    }
    None
}

#[test]
fn no_input_that_once_did_harm_does_it_again() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/reproducers");
    let reproducers: Vec<_> =
        fs::read_dir(&folder).expect("the reproducers").flatten().map(|entry| entry.path()).collect();
    assert!(reproducers.len() >= 12, "there are {}", reproducers.len());
    let faults = reproducers.iter().filter_map(|path| Some(format!("{}: {}", path.display(), fault(path)?)));
    let faults: Vec<String> = faults.collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_command_that_hangs_or_an_error_without_a_file_is_found_out() {
    let folder = Folder::new();
    let mut waits = Command::new(crate::common::LAPIDARY);
    waits.args(["compare", "a", "b"]);
    let (code, errors) = run(&mut waits, &folder.path("standard-error")).expect("it ends");
    assert!(code == Some(1) && errors.contains("error: "), "{code:?}: {errors}");
    let reproducer = tempfile::tempdir().expect("a temporary folder");
    fs::write(reproducer.path().join("commands.txt"), "info missing.cuts\n").expect("a writable folder");
    assert!(fault(reproducer.path()).is_some_and(|fault| fault.contains("exit code")), "it names none of its inputs");
}
