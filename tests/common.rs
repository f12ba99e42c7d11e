//! What the end-to-end tests share: running the binary, a small scene, comparing datasets.

use lapidary_core::dataset::Dataset;
use lapidary_interchange::image::{self, decode};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// The built program.
pub const LAPIDARY: &str = env!("CARGO_BIN_EXE_lapidary");

/// A folder for one test, with a small scene in it: a box over a floor of two triangles.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write("scene.obj", box_over_floor());
        folder.write("scene.mtl", "newmtl white\nKd 0.8 0.8 0.8\n".into());
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, contents: String) {
        fs::write(self.path(name), contents).expect("a writable folder");
    }

    /// Runs `lapidary` in the folder, options separated by blanks.
    pub fn run(&self, options: &str) -> Output {
        let output = self.command(options).output().expect("the program starts");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(!errors.contains("panicked"), "{options}: {errors}");
        output
    }

    pub fn command(&self, options: &str) -> Command {
        let mut command = Command::new(LAPIDARY);
        command.args(options.split_whitespace()).current_dir(self.0.path());
        // One sample, at the centers of pixels, takes a sixteenth of the time.
        let takes_many = ["render ", "sequence ", "reference "].iter().any(|name| options.starts_with(name));
        if takes_many && !options.contains("--aa") {
            command.args(["--aa", "1"]);
        }
        // Without it graphics libraries complain on standard error, which some tests want empty.
        command.env("XDG_RUNTIME_DIR", self.0.path());
        // Nobody's preferences.
        command.env("LAPIDARY_HOME", self.path("home"));
        command
    }

    /// Runs and expects success; returns standard output.
    pub fn succeed(&self, options: &str) -> String {
        let output = self.run(options);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{options}: {errors}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Runs and expects exit code 1; returns standard error.
    pub fn fail(&self, options: &str) -> String {
        let output = self.run(options);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{options}: {errors}");
        errors
    }

    /// Bakes the small scene to `name` with few lights.
    pub fn bake(&self, name: &str, more: &str) -> String {
        self.succeed(&format!("bake scene.obj -o {name} {SMALL} {more}"))
    }

    /// Relative RMSE of the bounced light of another dataset against the light paths that `bounces --out truth` has written.
    pub fn off_from_paths(&self, dataset: &str, solution: &str, options: &str) -> f64 {
        let render = format!("render {dataset} --solution {solution} --components indirect {options} --quiet");
        self.succeed(&format!("{render} --out other.exr"));
        self.succeed(&format!("compare other.exr truth/{solution}-paths.exr --json other.json --quiet"));
        self.json("other.json")["rel_rmse"].as_f64().expect("a number")
    }

    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&fs::read(self.path(name)).expect("a JSON file")).expect("JSON")
    }

    pub fn dataset(&self, name: &str) -> Dataset {
        Dataset::read(&self.path(name), image::decode).expect("a dataset")
    }
}

/// Options of a small bake.
pub const SMALL: &str = "--lights 1024 --pilot-clusters 64 --max-vertices 800 --progress none";

/// Everything in a dataset but the report, which holds times.
pub fn contents(dataset: &Dataset) -> (Vec<u16>, Vec<u32>, Vec<u32>, Vec<[u32; 3]>) {
    let (cuts, mesh) = (&dataset.cuts, &dataset.scene.mesh);
    (cuts.nodes().to_vec(), cuts.offsets().to_vec(), dataset.tree.order().to_vec(), mesh.triangles.clone())
}

/// Keys of a JSON object, sorted.
pub fn keys(value: &serde_json::Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

/// Contents of a file.
pub fn read(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Whether two outputs of this name are the same but for times that they tell: those of exr files are in their headers.
pub fn is_same_output(name: &str, a: &[u8], b: &[u8]) -> bool {
    let texels = |bytes: &[u8]| decode(bytes, Path::new(name)).ok().map(|picture| (picture.size, picture.texels));
    a == b || (name.ends_with(".exr") && texels(a).is_some_and(|a| texels(b) == Some(a)))
}

/// All files below a folder, by their path in it.
pub fn files_below(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() {
            found.extend(files_below(&path).into_iter().map(|(below, contents)| (format!("{name}/{below}"), contents)));
        } else {
            found.insert(name, read(&path));
        }
    }
    found
}

/// Copies a folder with all that is in it.
pub fn copy_folder(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &to)?
        } else {
            fs::copy(entry.path(), to).map(drop)?
        }
    }
    Ok(())
}

/// Number of files in a folder.
pub fn files_in(folder: &Path) -> usize {
    fs::read_dir(folder).expect("a folder").count()
}

fn box_over_floor() -> String {
    let mut text = String::from("mtllib scene.mtl\nusemtl white\no floor\n");
    for (x, z) in [(-2, -2), (-2, 2), (2, 2), (2, -2)] {
        text += &format!("v {x} 0 {z}\n");
    }
    text += "f 1 2 3\nf 1 3 4\no box\n";
    for y in [0.5, 1.0] {
        for (x, z) in [(-0.25, -0.25), (-0.25, 0.25), (0.25, 0.25), (0.25, -0.25)] {
            text += &format!("v {x} {y} {z}\n");
        }
    }
    text + "f 8 7 6 5\nf 9 10 11 12\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n"
}
