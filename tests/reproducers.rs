//! Inputs that once crashed, hung, or gave something else than they should, run by their command lines.

use crate::common::{Folder, copy_folder, files_below, read};
use lapidary_core::dataset::Dataset;
use lapidary_interchange::image;
use std::{
    collections::BTreeMap,
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
    let commands = fs::read_to_string(reproducer.join("commands.txt")).expect("the commands");
    for options in commands.lines() {
        let (code, errors) = match run(&mut folder.command(options), &folder.path("standard-error")) {
            Ok(ended) => ended,
            Err(hangs) => return Some(hangs),
        };
        let names_input =
            |text: &str| ["x.obj", "x.gltf", "x.glb", "x.cuts", "x.json"].iter().any(|x| text.contains(x));
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
            Some("cuts") => Dataset::read(&path, image::decode).err().map(|error| error.to_string()),
            Some("exr") => match image::read(&path) {
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

/// A bake of all parts, the smallest one.
const BAKE: &str = "bake scene.obj -o c.cuts --preset draft --mode all --lights 64 --sources 16 --levels 1 \
--sender-levels 1 --coarse-radius 0.8 --gather-rays 16 --max-vertices 60 --pilot-clusters 4 --progress none --chunks 4";

/// A bake that was stopped when all but its dataset was written.
struct Stopped {
    folder: Folder,
    /// Its checkpoint.
    files: BTreeMap<String, Vec<u8>>,
    /// The dataset of the bake that was not stopped.
    right: Vec<u8>,
}

impl Stopped {
    fn new() -> Self {
        let folder = Folder::new();
        folder.succeed(BAKE);
        let right = read(&folder.path("c.cuts"));
        fs::remove_file(folder.path("c.cuts")).expect("a file");
        let fails_at = |number: u32| {
            let mut command = folder.command(BAKE);
            let output = command.env("LAPIDARY_TEST_FAULT", format!("{number} no-space")).output().expect("it starts");
            assert_eq!(output.status.code(), Some(1), "write {number}");
            String::from_utf8_lossy(&output.stderr).into_owned()
        };
        (1..).map(fails_at).find(|errors| !errors.contains("c.cuts.partial")).expect("the dataset is written last");
        let files = files_below(&folder.path("c.cuts.partial"));
        assert!(files.contains_key("bake.json") && files.contains_key("chunk-00003.bin"), "{:?}", files.keys());
        Self { folder, files, right }
    }

    /// The manifest as it stands in its file, with one part replaced; its checksum fits, or is the old one.
    fn manifest(&self, part: &str, other: &str, fits: bool) -> Vec<u8> {
        let file = std::str::from_utf8(&self.files["bake.json"]).expect("a text");
        let (head, manifest) = file.split_once(",\"manifest\":").expect("a manifest with its checksum");
        let manifest = manifest.strip_suffix('}').expect("an object");
        let checksum = |manifest: &str| format!("{{\"checksum\":\"{}\"", blake3::hash(manifest.as_bytes()).to_hex());
        assert_eq!(head, checksum(manifest), "the checksum is that of the manifest's text");
        assert_eq!(manifest.matches(part).count(), 1, "{part}");
        let changed = manifest.replace(part, other);
        let head = if fits { checksum(&changed) } else { head.into() };
        format!("{head},\"manifest\":{changed}}}").into_bytes()
    }

    /// Resumes with another manifest. What is wrong with how it ends: it must be refused for this reason, or end with
    /// the right dataset.
    fn fault(&self, manifest: &[u8], reason: &str) -> Option<String> {
        let partial = self.folder.path("c.cuts.partial");
        let _ = fs::remove_dir_all(&partial);
        let _ = fs::remove_file(self.folder.path("c.cuts"));
        fs::create_dir(&partial).expect("a writable folder");
        for (name, contents) in &self.files {
            let contents = if name == "bake.json" { manifest } else { contents };
            fs::write(partial.join(name), contents).expect("a writable folder");
        }
        let mut command = self.folder.command(&format!("{BAKE} --resume"));
        match run(&mut command, &self.folder.path("standard-error")) {
            Ok((Some(0), _)) if read(&self.folder.path("c.cuts")) == self.right => None,
            Ok((Some(0), _)) => Some("the dataset is another one".into()),
            Ok((Some(1), errors)) if errors.contains("c.cuts.partial") && errors.contains(reason) => None,
            Ok((code, errors)) => Some(format!("exit code {code:?}: {errors}")),
            Err(hangs) => Some(hangs),
        }
    }
}

/// Numbers of chunks and orders of the light tree that once ended in a crash, a hang, or another dataset.
#[test]
fn no_changed_checkpoint_that_once_did_harm_does_it_again() {
    let stopped = Stopped::new();
    let file = String::from_utf8_lossy(&stopped.files["bake.json"]).into_owned();
    let (order, _) = file.split_once("\"tree_order\":[").expect("an order").1.split_once(']').expect("an array");
    let lights: Vec<&str> = order.split(',').collect();
    let changed = |changes: &[(usize, &str)]| {
        let mut lights = lights.clone();
        changes.iter().for_each(|&(at, light)| lights[at] = light);
        lights.join(",")
    };
    let chunks = ["18446744073709551615", "9223372036854775808", "4294967296", "10000000", "1000", "0"];
    let chunks = chunks.map(|chunks| ("\"chunks\":4", format!("\"chunks\":{chunks}"), "chunks for"));
    let doubled = changed(&[(0, lights[1])]);
    let beyond = changed(&[(47, "5126")]);
    let orders = [doubled, beyond].map(|other| (order, other, "no permutation"));
    let swapped = changed(&[(10, lights[25]), (25, lights[10])]);
    for (part, other, reason) in chunks.iter().chain(&orders) {
        for (fits, reason) in [(false, "checksum"), (true, reason)] {
            let fault = stopped.fault(&stopped.manifest(part, other, fits), reason);
            assert_eq!(fault, None, "{other}, fits: {fits}");
        }
    }
    assert_eq!(stopped.fault(&stopped.manifest(order, &swapped, false), "checksum"), None);
    assert_eq!(stopped.fault(&stopped.files["bake.json"], "it is resumed"), None, "nothing is changed");
    let forged = stopped.fault(&stopped.manifest(order, &swapped, true), "it is resumed");
    assert!(forged.is_some(), "negative control: another order gives another dataset");
}
