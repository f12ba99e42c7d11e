//! Writing that fails: the error names the file, what was there stays whole, nothing temporary is left, and the next run
//! ends as if nothing had been.

use crate::common::{Folder, files_below, is_same_output};
use std::{collections::BTreeMap, process::Command};

const BAKE: &str = "bake scene.obj -o out/a.cuts --lights 256 --pilot-clusters 16 --max-vertices 200 --mode all --sources 16 \
--levels 1 --sender-levels 1 --coarse-radius 0.8 --gather-rays 16 --chunks 2 --progress none --report out/report.json";

/// Each command, and the option by which it goes on.
const COMMANDS: [(&str, &str); 3] = [
    (BAKE, " --resume"),
    ("render a.cuts --size 64x48 --aa 1 --out out/a.exr --out out/a.png --stats out/stats.json", ""),
    ("export a.cuts --mitsuba out --env studio", ""),
];

/// Files whose contents tell times.
const TIMED: [&str; 2] = ["report.json", "stats.json"];

fn files(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    files_below(&folder.path("out"))
}

/// Puts older files in the place of all outputs.
fn put_old(folder: &Folder, right: &BTreeMap<String, Vec<u8>>) {
    std::fs::remove_dir_all(folder.path("out")).expect("a folder");
    for name in right.keys() {
        let path = folder.path("out").join(name);
        let parent = path.parent().expect("it lies in a folder");
        std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, "old")).expect("a writable folder");
    }
}

/// Checks what a failed command leaves, and that it goes on. Returns its standard error.
fn check_failed(
    folder: &Folder,
    mut command: Command,
    go_on: &str,
    right: &BTreeMap<String, Vec<u8>>,
) -> Option<String> {
    put_old(folder, right);
    let output = command.output().expect("the program starts");
    if output.status.success() {
        return None;
    }
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(right.keys().any(|name| errors.contains(name)) || errors.contains("a.cuts.partial"), "{errors}");
    for (name, contents) in files(folder) {
        assert!(!name.contains(".lapidary-"), "{name} is left: {errors}");
        let is_new = right.get(&name).is_some_and(|right| is_same_output(&name, right, &contents))
            || TIMED.contains(&name.as_str());
        let of_checkpoint = name.contains(".partial/");
        assert!(contents == b"old" || is_new || of_checkpoint, "{name} is neither old nor new: {errors}");
    }
    folder.succeed(go_on);
    let again = files(folder);
    for (name, contents) in right.iter().filter(|(name, _)| !TIMED.contains(&name.as_str())) {
        assert!(is_same_output(name, &again[name], contents), "{name} differs after {errors}");
    }
    Some(errors)
}

fn folder_with_dataset() -> Folder {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    std::fs::create_dir(folder.path("out")).expect("a writable folder");
    folder
}

#[test]
fn no_failed_write_loses_anything() {
    for (options, resume) in COMMANDS {
        let folder = folder_with_dataset();
        folder.succeed(options);
        let right = files(&folder);
        for kind in ["short", "no-space", "rename"] {
            let fails = |number: u32| {
                let mut command = folder.command(options);
                command.env("LAPIDARY_TEST_FAULT", format!("{number} {kind}"));
                check_failed(&folder, command, &format!("{options}{resume}"), &right).is_some()
            };
            let failed = (1..).take_while(|&number| fails(number)).count();
            assert!(failed >= right.len(), "{failed} writes for {} files of {options}", right.len());
        }
    }
}

/// The limit of the system on the size of files makes a write truly short.
#[test]
#[cfg(target_os = "linux")]
fn a_write_beyond_the_limit_of_the_system_loses_nothing() {
    let folder = folder_with_dataset();
    for (options, resume) in COMMANDS {
        std::fs::remove_dir_all(folder.path("out"))
            .and_then(|()| std::fs::create_dir(folder.path("out")))
            .expect("a folder");
        folder.succeed(options);
        let right = files(&folder);
        let script = format!("trap '' XFSZ; ulimit -f 1; exec {} {options}", crate::common::LAPIDARY);
        let mut command = Command::new("bash");
        command.args(["-c", &script]).current_dir(folder.path("")).env("XDG_RUNTIME_DIR", folder.path(""));
        let errors = check_failed(&folder, command, &format!("{options}{resume}"), &right);
        assert!(errors.is_some_and(|errors| errors.contains("File too large")), "{options}");
    }
}
