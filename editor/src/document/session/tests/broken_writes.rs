//! A save that is killed or fails leaves a whole session. This test program starts itself to be killed.

use super::*;
use std::{
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

/// File that the started test saves, and how often.
const FILE: &str = "LAPIDARY_TEST_SAVE";
const TIMES: &str = "LAPIDARY_TEST_SAVES";

/// Two sessions of different length.
fn documents() -> [Document; 2] {
    let short = Document::empty();
    let bookmarks = (0..200).map(|i| camera(&i.to_string())).collect();
    [short.clone(), Document { bookmarks, ..short }]
}

/// The body of the started test; on its own it does nothing.
#[test]
fn saves_when_another_test_asks() {
    let Some(file) = std::env::var_os(FILE).map(PathBuf::from) else { return };
    let times: usize = std::env::var(TIMES).ok().and_then(|times| times.parse().ok()).unwrap_or(usize::MAX);
    for document in documents().iter().cycle().take(times) {
        if let Err(error) = save(document, &Unknown::default(), &file) {
            eprintln!("error: {error}");
            std::process::exit(1);
        }
    }
}

fn started(file: &Path, times: &str, fault: &str) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "--nocapture", "document::session::tests::broken_writes::saves_when_another_test_asks"]);
    command.env(FILE, file).env(TIMES, times).env("LAPIDARY_TEST_FAULT", fault);
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// The texts of both sessions.
fn texts(file: &Path) -> [String; 2] {
    documents().map(|document| {
        save(&document, &Unknown::default(), file).unwrap();
        std::fs::read_to_string(file).unwrap()
    })
}

#[test]
fn a_killed_save_leaves_one_session_or_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("look.lapidary");
    let whole = texts(&file);
    let kills = std::env::var("LAPIDARY_KILLS").map_or(10, |kills| kills.parse().unwrap());
    let mut random = fastrand::Rng::with_seed(29);
    for kill in 0..kills {
        std::fs::remove_file(&file).unwrap();
        let mut child = started(&file, "", "");
        while !file.exists() {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it saved");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(random.u64(0..20_000)));
        child.kill().unwrap();
        assert_eq!(child.wait().unwrap().code(), None, "it saves until it is killed");
        assert!(whole.contains(&std::fs::read_to_string(&file).unwrap()), "kill {kill}");
        load(&file).unwrap();
    }
}

#[test]
fn a_save_that_fails_names_the_file_and_leaves_the_old_session_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("look.lapidary");
    let [first, second] = texts(&file);
    for fault in ["2 short", "2 no-space", "2 rename"] {
        let output = started(&file, "2", fault).wait_with_output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && errors.contains("look.lapidary"), "{fault}: {errors}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), first, "{fault}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{fault} leaves nothing temporary");
    }
    assert!(started(&file, "2", "3 short").wait().unwrap().success(), "negative control: there is no third save");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), second);
}
