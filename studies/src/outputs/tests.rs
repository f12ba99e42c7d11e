use super::*;
use crate::commands::Command;
use clap::{FromArgMatches, Subcommand};
use lapidary_core::output::folder_of;
use std::{any::TypeId, collections::BTreeSet, fs};

/// A folder with an input in it.
fn folder() -> (tempfile::TempDir, impl Fn(&str) -> PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().to_path_buf();
    fs::write(root.join("input"), b"in").unwrap();
    (folder, move |name| root.join(name))
}

fn refused(files: &CommandFiles) -> String {
    files.check().unwrap_err().to_string()
}

#[test]
fn outputs_are_apart_from_inputs_and_from_each_other() {
    let (_folder, path) = folder();
    let files = CommandFiles::default().reads([path("input")]);
    files.clone().writes([path("a"), path("b")]).check().unwrap();
    assert!(refused(&files.clone().writes([path("a"), path("input")])).contains("over an input"));
    assert!(refused(&files.clone().writes([path("a"), path("./a")])).contains("same file"));
    assert!(refused(&files.writes([path("a")]).fills(&path("."), ["a"])).contains("same file"));
}

#[test]
fn a_folder_to_fill_is_made_later_and_holds_no_input_of_its_names() {
    let (folder, path) = folder();
    let files = CommandFiles::default().reads([path("input")]);
    files.clone().fills(&path("new/deep"), ["a"]).check().unwrap();
    assert!(!path("new").exists(), "nothing is made");
    files.clone().fills(folder.path(), ["a", "x-*"]).check().unwrap();
    for name in ["input", "in*", "*put", "*"] {
        let text = refused(&files.clone().fills(folder.path(), [name]));
        assert!(text.contains("another folder") && text.contains("input"), "{name}: {text}");
    }
    files.clone().fills(folder.path(), ["input*input"]).check().unwrap();
    assert!(refused(&files.clone().fills(&path("input"), ["a"])).contains("no folder"));
    assert!(refused(&files.clone().fills(&path("input/deeper"), ["a"])).contains("no folder"));
    assert!(refused(&files.clone().fills(&path("n"), ["a", "b"]).fills(&path("n"), ["b"])).contains("same file"));
    assert!(
        refused(&CommandFiles::default().reads([folder.path()]).fills(folder.path(), ["a"])).contains("another folder")
    );
    #[cfg(target_os = "linux")]
    refused(&files.fills(Path::new("/proc/new"), ["a"]));
}

#[test]
fn what_a_folder_has_of_its_names_are_files() {
    let (folder, path) = folder();
    fs::create_dir_all(path("meshes/1.ply")).unwrap();
    let files = CommandFiles::default();
    files.clone().fills(folder.path(), ["meshes/2.ply", "1.ply", "input"]).check().unwrap();
    for name in ["meshes/1.ply", "meshes/*.ply", "meshes"] {
        assert!(refused(&files.clone().fills(folder.path(), [name])).contains("a folder"), "{name}");
    }
}

#[test]
fn a_pattern_stays_in_its_folder() {
    let (folder, path) = folder();
    fs::create_dir(path("deep")).unwrap();
    fs::write(path("deep/a.exr"), b"in").unwrap();
    let files = CommandFiles::default().reads([path("deep/a.exr")]);
    files.clone().fills(folder.path(), ["*.exr", "*xr"]).check().unwrap();
    assert!(refused(&files.fills(folder.path(), ["deep/*.exr"])).contains("another folder"));
}

#[test]
fn what_is_read_only_is_kept_but_not_written_over() {
    let (folder, path) = folder();
    let mut permissions = fs::metadata(path("input")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(path("input"), permissions).unwrap();
    fs::create_dir(path("folder")).unwrap();
    let files = CommandFiles::default();
    assert!(refused(&files.clone().fills(folder.path(), ["input"])).contains("read-only"));
    files.clone().completes(folder.path(), ["input"]).check().unwrap();
    assert!(refused(&files.clone().completes(folder.path(), ["folder"])).contains("is a folder"));
    assert!(refused(&files.reads([path("input")]).completes(folder.path(), ["input"])).contains("another folder"));
}

#[cfg(unix)]
#[test]
fn an_input_is_known_behind_a_link() {
    let (folder, path) = folder();
    std::os::unix::fs::symlink(path("input"), path("link")).unwrap();
    let files = CommandFiles::default().reads([path("link")]);
    assert!(refused(&files.clone().writes([path("input")])).contains("over an input"));
    assert!(refused(&files.fills(folder.path(), ["input"])).contains("another folder"));
}

/// Options that require another option.
const COMPANIONS: [(&str, &str, &str); 2] = [("compare", "out", "--map flip"), ("predict", "json", "--calibrate")];

/// Commands with two kinds of line, and the arguments that each kind lacks.
const ALTERNATIVES: [(&str, [&[&str]; 2]); 2] =
    [("bench", [&["against", "data"], &["file", "lights", "json"]]), ("bake", [&["update", "pose"], &["scene"]])];

/// A command line of each command with all its paths; other options keep their defaults. A command with an alternative has two.
fn lines() -> Vec<(String, BTreeSet<PathBuf>, Vec<String>)> {
    let commands = Command::augment_subcommands(clap::Command::new("lapidary"));
    let line = |command: &clap::Command, lacks: &[&str]| {
        let (mut line, mut paths) = (vec!["lapidary".to_owned(), command.get_name().to_owned()], BTreeSet::new());
        for argument in command.get_arguments() {
            if argument.get_value_parser().type_id() != TypeId::of::<PathBuf>()
                || lacks.contains(&argument.get_id().as_str())
            {
                continue;
            }
            let path = match argument.get_id().as_str() {
                id @ ("out" | "contact_sheet") => format!("{id}-of-{}/a.####.png", command.get_name()),
                id => format!("{id}-of-{}", command.get_name()),
            };
            line.extend(argument.get_long().map(|long| format!("--{long}")));
            line.push(path.clone());
            paths.insert(path.into());
            let needed =
                COMPANIONS.iter().find(|(name, id, _)| *name == command.get_name() && *id == argument.get_id());
            line.extend(needed.into_iter().flat_map(|(_, _, more)| more.split_whitespace()).map(str::to_owned));
        }
        (command.get_name().to_owned(), paths, line)
    };
    let kinds = |command: &clap::Command| {
        let alternatives = ALTERNATIVES.iter().find(|(name, _)| *name == command.get_name());
        alternatives.map_or(vec![[].as_slice()], |(_, lacks)| lacks.to_vec())
    };
    commands.get_subcommands().flat_map(|c| kinds(c).into_iter().map(move |lacks| line(c, lacks))).collect()
}

/// Every new option that names a file must be declared as read or written.
#[test]
fn every_path_of_every_command_is_an_input_or_an_output() {
    let lines = lines();
    assert!(lines.len() >= 15);
    for (name, paths, line) in lines {
        let matches = Command::augment_subcommands(clap::Command::new("lapidary")).try_get_matches_from(&line);
        let command = Command::from_arg_matches(&matches.unwrap_or_else(|e| panic!("{line:?}: {e}"))).unwrap();
        let files = command.files().unwrap();
        let known: BTreeSet<PathBuf> = files.inputs().chain(files.outputs()).map(Path::to_path_buf).collect();
        let told = |path: &&PathBuf| known.contains(*path) || known.contains(folder_of(path));
        let forgotten: Vec<_> = paths.iter().filter(|path| !told(path)).collect();
        assert!(forgotten.is_empty(), "{name} does not tell of {forgotten:?}");
    }
}
