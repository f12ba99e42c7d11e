//! Shell scripts replace both programs: they bake empty files and print known figures.
#![cfg(unix)]

use super::{super::jobs::JOBS, *};
use crate::{
    commands::bench::against::report::{Report, Times},
    terminal::{Console, Outcome},
};
use std::process::Command;

/// Number of jobs for bakes and frames of the still life.
const FEW: usize = 4;

const BROKEN: &str = "bench*) echo 'some words'; echo 'error: no light' >&2; exit 4;;";

/// Writes a script from another process: no thread can execute it while this process has it open for writing.
fn script(path: &Path, text: &str) {
    let write = "printf '%s' \"$1\" > \"$0\" && chmod +x \"$0\"";
    let written = Command::new("sh").arg("-c").arg(write).arg(path).arg(text).status();
    assert!(written.is_ok_and(|status| status.success()));
}

/// A program with frames of `total` milliseconds, these `bench` options, and shell cases before the usual ones.
fn program(options: &str, total: u32, cases: &str) -> (TempDir, Program) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lapidary");
    let sketched = format!(r#"{{"sketch_milliseconds": 5, "finished_milliseconds": {total}}}"#);
    let turned = format!(r#"{{"light_milliseconds": 2, "finished_milliseconds": {total}}}"#);
    script(
        &path,
        &format!(
            r#"#!/bin/sh
case "$*" in
    "bench --help") echo "{options}";;
    --version) echo "lapidary {total}";;
    {cases}
    info*) ;;
    *bake*) : > "$5";;
    *--drag*) echo '{{"details": [{{"light_milliseconds": {total}, "sketch_milliseconds": 1}}]}}';;
    *--edits*) echo '{{"edit": {sketched}, "orbit": {sketched}, "turned": {turned}}}';;
    bench*) echo '{{"runs": [{{"milliseconds": {{"total": {total}}}}}], "rotation_milliseconds": {total}, "light_moved_milliseconds": {total}}}';;
    edit*) echo "error: no window" >&2; exit 1;;
esac
"#
        ),
    );
    let program = Program::open(&path).unwrap();
    (folder, program)
}

const ALL_OPTIONS: &str = "--json --sun --drag --edits cuts+gloss";

/// Measures some jobs with a time limit per run.
fn measured(this: &Program, other: &Program, jobs: &[Job], limit: Duration) -> Vec<Row> {
    let (data, steps) = (DataFolder::find(None).unwrap(), Steps::new(Console { quiet: true }));
    let limits = Limits { run: limit, ..Limits::USUAL };
    Contest::new([this, other], &data, limits, &steps).unwrap().measure(jobs).unwrap()
}

/// Rows of `jobs` beside a program with these options, cases and time limit.
fn beside(options: &str, cases: &str, jobs: &[Job], limit: Duration) -> (Vec<Row>, Outcome) {
    let ((_a, this), (_b, other)) = (program(ALL_OPTIONS, 40, ""), program(options, 20, cases));
    let rows = measured(&this, &other, jobs, limit);
    let outcome = Report::new([&this, &other], rows.clone(), Duration::ZERO, Some(1.5)).outcome();
    (rows, outcome)
}

const PATIENT: Duration = Duration::from_secs(20);

#[test]
fn figures_of_both_programs_are_paired_on_every_dataset() {
    let (rows, outcome) = beside(ALL_OPTIONS, "", &JOBS[..FEW], PATIENT);
    assert_eq!(rows[3].name, "still life: frame, studio");
    let expected = Times::new(vec![40.0, 40.0], vec![20.0, 20.0]);
    assert!([&rows[3].own, &rows[3].on_this, &rows[3].on_other].iter().all(|times| **times == expected));
    assert!(rows[0].own.this.len() == 1 && rows.iter().all(|row| row.remark.is_none() && !row.failed));
    assert_eq!(outcome, Outcome::OutOfBounds);
    let ((_a, this), (_b, other)) = (program(ALL_OPTIONS, 40, ""), program(ALL_OPTIONS, 30, ""));
    let rows = measured(&this, &other, &JOBS[FEW..FEW + 1], PATIENT);
    assert_eq!(rows[0].remark.as_deref(), Some("this program has no dataset, since its bake failed"), "not baked");
}

#[test]
fn equal_programs_are_within_bounds() {
    let ((_a, this), (_b, other)) = (program(ALL_OPTIONS, 20, ""), program(ALL_OPTIONS, 20, ""));
    let mut rows = measured(&this, &other, &JOBS[..FEW], PATIENT);
    rows.retain(|row| !row.name.ends_with("bake"));
    assert_eq!(Report::new([&this, &other], rows, Duration::ZERO, Some(1.5)).outcome(), Outcome::Done);
}

#[test]
fn a_program_that_fails_on_a_row_is_told_and_the_others_go_on() {
    let (rows, outcome) = beside(ALL_OPTIONS, BROKEN, &JOBS[..FEW], PATIENT);
    let remark = "the other program failed (exit status: 4): no light";
    assert!(rows[3].failed && rows[3].remark.as_deref() == Some(remark), "{:?}", rows[3].remark);
    assert!(rows[3].own.this == [40.0, 40.0] && rows[3].own.other.is_empty());
    assert!(rows[..3].iter().all(|row| !row.failed && row.own.other.len() == 1));
    assert_eq!(outcome, Outcome::Failed, "also where a row is above the bound");
}

#[test]
fn a_program_that_hangs_is_stopped() {
    let (rows, outcome) = beside(ALL_OPTIONS, "bench*) exec sleep 60;;", &JOBS[..FEW], Duration::from_millis(300));
    let remark = "the other program was stopped after 0.3 s";
    assert!(rows[3].remark.as_deref() == Some(remark) && !rows[0].failed, "{:?}", rows[3].remark);
    assert_eq!(outcome, Outcome::Failed);
}

#[test]
fn an_older_program_lacks_options_and_suns() {
    let jobs = || JOBS[..FEW + 1].iter().chain(JOBS.iter().filter(|job| job.needs.is_some()));
    let rows = |options: &str, cases: &str| {
        let ((_a, this), (_b, other)) = (program(ALL_OPTIONS, 40, ""), program(options, 20, cases));
        let (data, steps) = (DataFolder::find(None).unwrap(), Steps::new(Console { quiet: true }));
        let contest = Contest::new([&this, &other], &data, Limits::USUAL, &steps).unwrap();
        jobs().flat_map(|job| contest.rows_of(job).unwrap()).collect::<Vec<_>>()
    };
    let no_suns = "*--sun*) exit 1;;";
    let older = rows("--json", no_suns);
    assert!(older[..FEW + 2].iter().all(|row| !row.failed), "{older:?}");
    let is_lacking = |row: &Row, option: &str| {
        row.remark.as_ref().is_some_and(|remark| *remark == format!("the other program has no {option}"))
    };
    let (glossy, others) = older[FEW + 2..].split_at(2);
    let (drags, edits) = others.split_at(4);
    assert!(glossy.iter().all(|row| is_lacking(row, "cuts+gloss") && row.own.this.len() == 2), "{glossy:?}");
    assert!(drags.iter().all(|row| is_lacking(row, "--drag") && row.own.this.len() == 2), "{drags:?}");
    assert!(edits.len() == 16 && edits.iter().all(|row| is_lacking(row, "--edits")), "{edits:?}");
    assert!(
        rows(ALL_OPTIONS, no_suns)[FEW + 1].failed,
        "negative control, one that says it has suns is asked for them"
    );
}

#[test]
fn the_suite_of_an_older_program_has_its_edits() {
    let suite =
        r#"bench\ --suite*) echo '{"figures": [{"name": "color-box: orbit, finished", "milliseconds": 50}]}';;"#;
    let this = r#"*--edits*) echo '{"orbit": {"finished_milliseconds": 75}, "edit": {"sketch_milliseconds": 1}}';;"#;
    let ((_a, this), (_b, other)) = (program(ALL_OPTIONS, 40, this), program("--json --suite", 20, suite));
    let is_color_box = |job: &&Job| SCENES[job.scene].name == "color box";
    let (data, steps) = (DataFolder::find(None).unwrap(), Steps::new(Console { quiet: true }));
    let contest = Contest::new([&this, &other], &data, Limits::USUAL, &steps).unwrap();
    let bake = JOBS.iter().filter(is_color_box).find(|job| matches!(job.work, Work::Bake)).unwrap();
    contest.rows_of(bake).unwrap();
    let edits: Vec<&Job> = JOBS.iter().filter(is_color_box).filter(|job| job.needs == Some(EDITS)).collect();
    let rows = contest.rows_beside_suite(&edits).unwrap();
    let orbit = rows.iter().find(|row| row.name == "color box: orbit, finished").unwrap();
    assert!(orbit.own == Times::new(vec![75.0, 75.0], vec![50.0, 50.0]) && !orbit.failed, "{orbit:?}");
    let edit = rows.iter().find(|row| row.name == "color box: edit, first sketch").unwrap();
    assert_eq!(edit.remark.as_deref(), Some("the other program does not report it"), "negative control");
}

#[test]
fn a_dataset_of_another_format_is_left_out_without_a_remark() {
    let (rows, _) = beside(ALL_OPTIONS, "info*) exit 1;;", &JOBS[..FEW], PATIENT);
    assert!(rows[3].on_this.other.is_empty() && rows[3].on_other.other.len() == 2 && !rows[3].failed);
    let (rows, _) = beside(ALL_OPTIONS, "*bake*) echo 'error: no room' >&2; exit 1;;", &JOBS[..FEW], PATIENT);
    assert_eq!(rows[0].remark.as_deref(), Some("the other program failed (exit status: 1): no room"));
    assert_eq!(rows[3].remark.as_deref(), Some("the other program has no dataset, since its bake failed"));
    assert!(rows[3].on_this.other.len() == 2 && rows[3].own.other.is_empty(), "it can use the other dataset");
}

#[test]
fn a_window_that_ends_or_a_missing_display_is_told() {
    let ((_a, this), (_b, other)) = (program(ALL_OPTIONS, 40, ""), program(ALL_OPTIONS, 20, ""));
    let jobs = [&JOBS[0], JOBS.iter().find(|job| matches!(job.work, Work::Window)).unwrap()];
    let (data, steps) = (DataFolder::find(None).unwrap(), Steps::new(Console { quiet: true }));
    let contest = Contest::new([&this, &other], &data, Limits::USUAL, &steps).unwrap();
    let rows: Vec<Row> = jobs.iter().flat_map(|job| contest.rows_of(job).unwrap()).collect();
    let remark = rows[1].remark.as_deref().unwrap_or_default();
    match rows[1].failed {
        true => assert_eq!(remark, "this program failed (exit status: 1): no window"),
        false => assert!(remark.starts_with("left out: "), "{remark}"),
    }
}

#[test]
fn files_that_are_no_such_program_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, text: Option<&str>| {
        let path = folder.path().join(name);
        text.into_iter().for_each(|text| script(&path, text));
        let message = Program::open(&path).unwrap_err().to_string();
        assert!(message.contains("name a program of lapidary") && message.ends_with(&format!("{name})")), "{message}");
        message
    };
    assert!(refused("gone", None).contains("cannot be started"));
    assert!(refused("text", Some("neither a script nor a program")).contains("cannot be started"));
    assert!(refused("broken", Some("#!/bin/sh\necho 'error: no memory' >&2; exit 9")).contains("no memory"));
    assert!(refused("silent", Some("#!/bin/sh\n")).contains("no `bench --json`"));
}

#[test]
fn ctrl_c_ends_a_run() {
    let (_folder, program) = program(ALL_OPTIONS, 40, "bench*) exec sleep 60;;");
    let patience = Patience { limit: PATIENT, stops: &|| true };
    assert!(matches!(program.run(&["bench"], patience), Err(RunError::Interrupted)));
}
