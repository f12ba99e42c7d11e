//! The path reference against Mitsuba 3, by the scripts in `tests/crosscheck`. Needs Python with the packages of its
//! `requirements.txt`, by the name in `LAPIDARY_PYTHON`; skipped aloud where it is not there, unless
//! `LAPIDARY_REQUIRE_MITSUBA` is set.

use crate::common::{Folder, LAPIDARY};
use std::process::{Command, Output};

const SCRIPTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/crosscheck");

/// Python in the folder of the scripts.
fn python() -> Command {
    let mut command = Command::new(std::env::var_os("LAPIDARY_PYTHON").unwrap_or("python3".into()));
    command.current_dir(SCRIPTS).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// Whether Python has the packages; says aloud that a test is skipped if it has not.
fn has(packages: &str) -> bool {
    let reason = match python().args(["-c", &format!("import {packages}")]).output() {
        Ok(output) if output.status.success() => return true,
        Ok(output) => said(&output),
        Err(error) => error.to_string(),
    };
    assert!(
        std::env::var_os("LAPIDARY_REQUIRE_MITSUBA").is_none(),
        "LAPIDARY_REQUIRE_MITSUBA is set, but Python has no {packages}: {reason}"
    );
    eprintln!(
        "SKIPPED: Python has no {packages}; pip install -r tests/crosscheck/requirements.txt ({})",
        reason.trim()
    );
    false
}

#[test]
fn errors_are_estimated_without_their_noise() {
    if has("numpy") {
        let output = python().args(["-m", "unittest", "test_estimate"]).output().expect("Python starts");
        assert!(output.status.success(), "{}", said(&output));
    }
}

#[test]
fn paths_are_those_of_an_independent_renderer() {
    if has("numpy, mitsuba") {
        let output =
            python().args(["crosscheck.py", "--small", "--lapidary", LAPIDARY]).output().expect("Python starts");
        assert!(output.status.success(), "{}", said(&output));
        println!("{}", said(&output));
    }
}

#[test]
fn a_missing_package_is_told_with_its_remedy() {
    if !has("sys") {
        return;
    }
    let folder = Folder::new();
    folder.write("mitsuba.py", "raise ImportError('no such package')\n".into());
    let output = python()
        .env("PYTHONPATH", folder.path(""))
        .args(["crosscheck.py", "--small", "--lapidary", LAPIDARY])
        .output()
        .expect("Python starts");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("requirements.txt"), "{}", said(&output));
}
