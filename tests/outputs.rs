//! No command writes over an input, or over anything but a file. An output that cannot be written is told before the work begins:
//! all inputs here are damaged, so that a command that reads one first complains of that.

use crate::common::{Folder, LAPIDARY, SMALL, files_in};
use clap::Subcommand;
use lapidary_core::lock::OutputLock;
use lapidary_studies::commands::Command;
use std::{any::TypeId, fs, path::PathBuf, process::Stdio};

enum Kind {
    /// A file, of any name that ends in `.png`.
    File,
    /// A folder that is filled.
    Folder,
    /// Files numbered from 1.
    Frames,
    /// A file whose folder is made.
    Sheet,
}

/// Every option that names an output, with a command line; `{}` stands for the output.
const OUTPUTS: [(&str, &str, Kind, &str); 20] = [
    ("bake", "output", Kind::File, "bake a.cuts -o {}"),
    ("bake", "report", Kind::File, "bake a.cuts -o b.cuts --report {}"),
    ("render", "out", Kind::File, "render a.cuts --out {}"),
    ("render", "stats", Kind::File, "render a.cuts --stats {}"),
    ("sequence", "out", Kind::Frames, "sequence a.cuts --turn object --frames 2 --out {}"),
    ("sequence", "contact_sheet", Kind::Sheet, "sequence a.cuts --turn object --out f.##.png --contact-sheet {}"),
    ("reference", "out", Kind::File, "reference a.cuts --out {}"),
    ("bounces", "out", Kind::Folder, "bounces a.cuts --out {}"),
    ("ladder", "out", Kind::Folder, "ladder a.cuts --out {}"),
    ("evidence", "out", Kind::Folder, "evidence --scenes a.cuts --no-bundled --out {}"),
    ("explain", "out", Kind::Folder, "explain a.cuts --out {}"),
    ("predict", "out", Kind::File, "predict a.cuts --out {}"),
    ("predict", "json", Kind::File, "predict a.cuts --out p.png --calibrate --json {}"),
    ("compare", "json", Kind::File, "compare a.cuts b.png --json {}"),
    ("compare", "out", Kind::File, "compare a.cuts b.png --map flip --out {}"),
    ("export", "mitsuba", Kind::Folder, "export a.cuts --mitsuba {}"),
    ("export", "materials", Kind::File, "export a.cuts --materials {}"),
    ("demo", "out", Kind::Folder, "demo --data a --out {}"),
    ("bench", "json", Kind::File, "bench a.cuts --json {}"),
    ("bench", "json", Kind::File, "bench --against a.cuts --json {}"),
];

/// Options that name an input; the dataset, the lights and the material are those of many commands.
const INPUTS: [&str; 14] = [
    "animation",
    "backplate",
    "file",
    "lights",
    "material",
    "scene",
    "scenes",
    "data",
    "test",
    "reference",
    "against",
    "original",
    "pose",
    "update",
];

#[test]
fn every_option_that_names_a_path_is_tried() {
    let commands = Command::augment_subcommands(clap::Command::new("lapidary"));
    for command in commands.get_subcommands() {
        for argument in command.get_arguments() {
            let (command, argument, of) =
                (command.get_name(), argument.get_id(), argument.get_value_parser().type_id());
            let tried = OUTPUTS.iter().any(|(c, a, ..)| *c == command && argument == a);
            let is_input = INPUTS.iter().any(|input| argument == input);
            assert!(
                of != TypeId::of::<PathBuf>() || tried || is_input,
                "say whether {command} reads or writes {argument}"
            );
        }
    }
}

const CONTENTS: &str = "no dataset, no scene, no picture";

/// A folder with damaged inputs, and with what is no output.
fn folder() -> Folder {
    let folder = Folder::new();
    for name in ["a.cuts", "b.png", "file", "kept.png"] {
        folder.write(name, CONTENTS.into());
    }
    fs::hard_link(folder.path("a.cuts"), folder.path("input.png")).expect("a name more");
    fs::create_dir(folder.path("folder.png")).expect("a folder");
    fs::create_dir_all(folder.path("frames/1.png")).expect("a folder");
    let mut permissions = fs::metadata(folder.path("kept.png")).expect("a file").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(folder.path("kept.png"), permissions).expect("a file of ours");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path("file"), folder.path("link.png")).expect("a link");
        std::os::unix::fs::symlink(folder.path("gone"), folder.path("dangling")).expect("a link");
        let made = std::process::Command::new("mkfifo").arg(folder.path("pipe.png")).status();
        assert!(made.is_ok_and(|s| s.success()));
    }
    folder
}

/// What the kinds of outputs cannot be, each with a word of the message.
fn refused(kind: &Kind) -> Vec<(&'static str, &'static str)> {
    let everywhere: &[_] = match kind {
        Kind::File | Kind::Sheet => {
            &[("input.png", "over an input"), ("folder.png", "is a folder"), ("kept.png", "read-only")]
        }
        Kind::Folder => &[("file", "no folder"), ("file/inner", "no folder")],
        Kind::Frames => &[("frames/#.png", "is a folder"), ("file/#.png", "no folder")],
    };
    let unix: &[_] = match kind {
        _ if !cfg!(target_os = "linux") => &[],
        Kind::File | Kind::Sheet => &[("link.png", "symbolic link"), ("pipe.png", "a pipe"), ("/proc/a.png", "/proc")],
        Kind::Folder => &[("dangling", "no folder"), ("pipe.png", "no folder"), ("/proc/new", "/proc")],
        Kind::Frames => &[("/proc/#.png", "/proc")],
    };
    let folder: &[_] = if matches!(kind, Kind::File) { &[("missing/a.png", "no folder")] } else { &[] };
    [everywhere, unix, folder].concat()
}

#[test]
fn no_command_writes_where_it_must_not() {
    let folder = folder();
    for (.., kind, line) in &OUTPUTS {
        for (output, word) in refused(kind) {
            let line = line.replace("{}", output);
            let message = folder.fail(&line);
            assert!(message.contains(word), "{line}: {message}");
        }
        let good = if matches!(kind, Kind::Frames) { "good/#.png" } else { "good.png" };
        let message = folder.fail(&line.replace("{}", good));
        let input = if line.starts_with("demo") { "--data" } else { "a.cuts" };
        assert!(message.contains(input), "negative control, the input is what is wrong: {line}: {message}");
        let _ = fs::remove_dir_all(folder.path("good.png"));
    }
    for name in ["a.cuts", "b.png", "file", "kept.png"] {
        assert_eq!(fs::read_to_string(folder.path(name)).expect("a file"), CONTENTS, "{name}");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = |name: &str| fs::symlink_metadata(folder.path(name)).expect("it stays").file_type();
        assert!(kind("link.png").is_symlink() && kind("dangling").is_symlink() && kind("pipe.png").is_fifo());
        assert!(!folder.path("gone").exists());
    }
}

#[test]
fn two_outputs_of_one_command_are_two_files() {
    let folder = folder();
    for line in [
        "bake a.cuts -o b.cuts --report ./b.cuts",
        "render a.cuts --out a.png --out a.exr --stats a.exr",
        "sequence a.cuts --turn object --out f.##.png --out f.##.png",
        "sequence a.cuts --turn object --out f.##.png --contact-sheet f.01.png",
        "compare a.cuts b.png --map flip --out c.png --json c.png",
    ] {
        let message = folder.fail(line);
        assert!(message.contains("two outputs are the same file"), "{line}: {message}");
    }
}

/// Not only what the command line names is an output.
#[test]
fn files_in_a_folder_that_is_filled_are_no_inputs() {
    let folder = folder();
    fs::create_dir(folder.path("out")).expect("a folder");
    for name in ["environment.exr", "ladder.json", "f.2.exr", "cuts.cuts", "report.json"] {
        folder.write(&format!("out/{name}"), CONTENTS.into());
    }
    for line in [
        "export a.cuts --env out/environment.exr --mitsuba out",
        "ladder a.cuts --material out/ladder.json --out out",
        "sequence a.cuts --turn object --frames 3 --env out/f.2.exr --out out/f.#.exr",
        "demo --data out --out ./out",
    ] {
        let message = folder.fail(line);
        assert!(message.contains("another folder"), "{line}: {message}");
    }
    let message = folder.fail("ladder out/cuts.cuts --out out");
    assert!(!message.contains("another folder"), "negative control: ladder writes no such file: {message}");
    assert_eq!(fs::read_to_string(folder.path("out/environment.exr")).expect("a file"), CONTENTS);
}

/// A probe under a name that could be known was written through a link.
#[cfg(unix)]
#[test]
fn a_link_under_a_name_that_can_be_known_leads_nowhere() {
    let folder = folder();
    fs::create_dir(folder.path("out")).expect("a folder");
    let script = format!("ln -s ../file out/.lapidary-$$ && exec {LAPIDARY} ladder a.cuts --out out");
    let output = std::process::Command::new("sh").args(["-c", &script]).current_dir(folder.path(".")).output();
    let message = String::from_utf8_lossy(&output.expect("a shell").stderr).into_owned();
    assert!(message.contains("a.cuts"), "the folder was taken, the dataset is what is wrong: {message}");
    assert_eq!(fs::read_to_string(folder.path("file")).expect("a file"), CONTENTS);
    assert_eq!(fs::read_dir(folder.path("out")).expect("a folder").count(), 1, "the link");
}

/// The test holds the lock, as another run of the program would.
#[test]
fn a_folder_is_filled_by_one_process_at_a_time() {
    let folder = Folder::new();
    folder.bake("a.cuts", "--mode cuts --sources 256");
    let small = "--size 8x6 --env studio";
    for line in [
        format!("ladder a.cuts {small} --illum-cuts 4 --out out"),
        format!("explain a.cuts {small} --pixel 4,3 --no-split --out out"),
        format!("export a.cuts {small} --mitsuba out"),
        format!("bounces a.cuts {small} --spp 2 --no-samples --out out"),
        "evidence --quick --out out".into(),
        "demo --out out".into(),
    ] {
        fs::create_dir(folder.path("out")).expect("a folder");
        let held = OutputLock::acquire(&folder.path("out/.lapidary")).expect("nobody else");
        let message = folder.fail(&line);
        let process = format!("process {}", std::process::id());
        assert!(message.contains(&process) && message.contains("(out)"), "{line}: {message}");
        assert_eq!(files_in(&folder.path("out")), 1, "{line}: nothing but the lock");
        drop(held);
        if !line.starts_with("evidence") && !line.starts_with("demo") {
            folder.succeed(&line);
            assert!(!folder.path("out/.lapidary.lock").exists(), "negative control: {line}");
        }
        fs::remove_dir_all(folder.path("out")).expect("a folder of ours");
    }
}

#[test]
fn two_sequences_of_one_name_do_not_mix() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let line = |exposure: i32, out: &str| {
        format!(
            "sequence a.cuts --size 64x48 --backend cpu --exposure {exposure} --turn object --frames 6 --out {out}/f.#.png"
        )
    };
    let frames =
        |out: &str| (1..=6).map(|n| fs::read(folder.path(&format!("{out}/f.{n}.png"))).ok()).collect::<Vec<_>>();
    for exposure in [0, 1] {
        folder.succeed(&line(exposure, &exposure.to_string()));
    }
    let runs = [0, 1].map(|exposure| {
        let mut command = folder.command(&line(exposure, "both"));
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
    });
    let [first, second] = runs.map(|run| run.wait_with_output().expect("it ends"));
    let (winner, other) = if first.status.success() { (0, &second) } else { (1, &first) };
    let message = String::from_utf8_lossy(&other.stderr);
    assert_eq!((first.status.success(), second.status.success()), (winner == 0, winner == 1), "{message}");
    // Where one had ended before the other began, its frames are there.
    let refused = message.contains("is writing the output") || message.contains("are there already");
    assert!(refused && message.contains("both"), "{message}");
    assert!(frames("both") == frames(&winner.to_string()), "the frames are those of one run");
    assert!(frames("0") != frames("1"), "negative control");
}

#[test]
fn a_bake_over_a_picture_of_its_scene_is_refused() {
    let folder = Folder::new();
    folder.write("scene.mtl", "newmtl white\nKd 0.8 0.8 0.8\nmap_Kd wood.tga\n".into());
    let mut tga = vec![0_u8; 18];
    (tga[2], tga[12], tga[14], tga[16]) = (2, 1, 1, 24);
    tga.extend([10, 20, 30]);
    fs::write(folder.path("wood.tga"), &tga).expect("a writable folder");
    for output in ["wood.tga", "scene.mtl"] {
        let before = fs::read(folder.path(output)).expect("an input");
        let message = folder.fail(&format!("bake scene.obj -o {output} {SMALL}"));
        assert!(message.contains("over an input") && message.contains(output), "{message}");
        assert!(fs::read(folder.path(output)).expect("an input") == before);
    }
    folder.bake("a.cuts", "");
    // Nor is a picture written over one of its material.
    fs::rename(folder.path("wood.tga"), folder.path("wood.png")).expect("a picture");
    folder.write("m.json", r#"{"maps": {"base_color": {"file": "wood.png"}}}"#.into());
    let line = |out: &str| format!("render a.cuts --material m.json --env studio --size 8x6 --out {out}");
    let message = folder.fail(&line("wood.png"));
    assert!(message.contains("over an input") && message.contains("wood.png"), "{message}");
    assert!(fs::read(folder.path("wood.png")).expect("a picture") == tga);
}
