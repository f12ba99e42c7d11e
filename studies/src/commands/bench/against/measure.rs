//! Alternating runs of both programs, job by job.

use super::{
    first_picture::Display,
    jobs::{COMMON, EDITS, Job, SCENES, Work},
    program::{Finished, Patience, Program, RunError},
    report::Row,
    runs::{Figures, Runs, Side, rows},
};
use crate::{args::DeviceArgs, bundled::DataFolder, terminal::Steps};
use anyhow::{Context, Result};
use lapidary_precompute::Observer;
use lapidary_render::BackendError;
use serde_json::Value;
use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
    time::Duration,
};
use tempfile::TempDir;

/// Option of older programs that measures edits of all scenes at once.
const SUITE: &str = "--suite";

/// Option that programs with suns have.
const SUN: &str = "--sun";

/// Time limits of runs: several times the duration on two cores.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// A bake.
    pub bake: Duration,
    /// Any other run.
    pub run: Duration,
    /// A whole suite.
    pub suite: Duration,
}

impl Limits {
    /// Limits of a comparison.
    pub const USUAL: Self =
        Self { bake: Duration::from_secs(240), run: Duration::from_secs(120), suite: Duration::from_secs(420) };
}

/// Both programs and their working folder.
pub struct Contest<'a> {
    this: &'a Program,
    other: &'a Program,
    data: &'a DataFolder,
    limits: Limits,
    steps: &'a Steps,
    folder: TempDir,
}

impl<'a> Contest<'a> {
    /// Prepares a comparison; `steps` can interrupt it.
    ///
    /// # Errors
    /// The temporary folder is not writable.
    pub fn new(
        [this, other]: [&'a Program; 2],
        data: &'a DataFolder,
        limits: Limits,
        steps: &'a Steps,
    ) -> Result<Self> {
        let folder =
            tempfile::tempdir().context("cannot bake to the folder for temporary files; check its free space")?;
        Ok(Self { this, other, data, limits, steps, folder })
    }

    /// The rows of all jobs.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn measure(&self, jobs: &[Job]) -> Result<Vec<Row>> {
        let is_in_suite = |job: &&Job| job.needs == Some(EDITS) && !self.other.has(EDITS) && self.other.has(SUITE);
        let (in_suite, alone): (Vec<&Job>, Vec<&Job>) = jobs.iter().partition(is_in_suite);
        let mut rows = Vec::new();
        for job in alone {
            rows.extend(self.rows_of(job)?);
        }
        if !in_suite.is_empty() {
            rows.extend(self.rows_beside_suite(&in_suite)?);
        }
        Ok(rows)
    }

    fn rows_of(&self, job: &Job) -> Result<Vec<Row>> {
        if let Some(reason) = missing_here(&job.work) {
            return Ok(job.figures.iter().map(|figure| Row::left_out(job.name_of(figure), &reason)).collect());
        }
        self.begin(job);
        let mut all = self.combinations(job)?;
        for round in 0..job.rounds {
            for side in Side::in_turn(round) {
                for runs in all.iter_mut().filter(|runs| runs.program == side && runs.trouble.is_none()) {
                    runs.add(self.figures(job, runs.program, runs.dataset)?);
                }
            }
        }
        Ok(rows(job, &all))
    }

    /// Runs this program before and after the other's suite, so that the spread includes machine drift.
    fn rows_beside_suite(&self, jobs: &[&Job]) -> Result<Vec<Row>> {
        let mut own: Vec<Runs> = jobs.iter().map(|_| Runs::new(Side::This, Side::This)).collect();
        self.add_edits(jobs, &mut own)?;
        self.steps.begin("bench --suite of the other program, which takes minutes");
        let data = self.data.path();
        let words: [&OsStr; 5] =
            ["bench".as_ref(), SUITE.as_ref(), "--json".as_ref(), "--data".as_ref(), data.as_ref()];
        let suite = self.json(Side::Other, &words, self.limits.suite)?;
        self.add_edits(jobs, &mut own)?;
        let beside = |(job, this): (&&Job, Runs)| {
            let mut other = Runs::new(Side::Other, Side::Other);
            let figures = suite.as_ref().map(|suite| job.in_suite(suite)).map_err(Clone::clone);
            this.figures.iter().for_each(|_| other.add(figures.clone()));
            rows(job, &[this, other])
        };
        Ok(jobs.iter().zip(own).flat_map(beside).collect())
    }

    fn add_edits(&self, jobs: &[&Job], own: &mut [Runs]) -> Result<()> {
        for (job, runs) in jobs.iter().zip(own).filter(|(_, runs)| runs.trouble.is_none()) {
            self.begin(job);
            runs.add(self.figures(job, Side::This, Side::This)?);
        }
        Ok(())
    }

    fn begin(&self, job: &Job) {
        let names: Vec<&str> = job.figures.iter().map(|figure| figure.name).collect();
        self.steps.begin(&format!("{}: {}", SCENES[job.scene].name, names.join("; ")));
    }

    /// Each program on its own dataset, and on the other's if it can read it: distant versions have different formats.
    fn combinations(&self, job: &Job) -> Result<Vec<Runs>> {
        let mut all = vec![Runs::new(Side::This, Side::This), Runs::new(Side::Other, Side::Other)];
        if job.is_crossed {
            for (program, dataset) in [(Side::This, Side::Other), (Side::Other, Side::This)] {
                let path = self.dataset(job, dataset);
                let words = ["info".as_ref(), path.as_os_str(), "--json".as_ref()];
                if path.is_file() && self.run(program, &words, self.limits.run)?.is_ok() {
                    all.push(Runs::new(program, dataset));
                }
            }
        }
        Ok(all)
    }

    /// Figures of one run; the inner error becomes a remark.
    fn figures(&self, job: &Job, side: Side, dataset: Side) -> Result<Result<Figures, String>> {
        let path = self.dataset(job, dataset);
        if let Some(option) = job.needs.filter(|option| !self.program(side).has(option)) {
            return Ok(Err(format!("has no {option}")));
        }
        if !matches!(job.work, Work::Bake) && !path.is_file() {
            return Ok(Err("has no dataset, since its bake failed".into()));
        }
        match job.work {
            Work::Bake => self.bake(job, side, &path),
            Work::Bench(options) => self.bench(job, side, &path, "cpu", options),
            Work::Adapter(options) => self.bench(job, side, &path, "gpu", options),
            Work::Window => self.first_picture(side, &path),
        }
    }

    fn bake(&self, job: &Job, side: Side, output: &Path) -> Result<Result<Figures, String>> {
        let scene = &SCENES[job.scene];
        let path = self.data.scene(scene.file);
        let mut words: Vec<&OsStr> = vec!["--quiet".as_ref(), "bake".as_ref(), path.as_ref(), "-o".as_ref()];
        words.push(output.as_ref());
        words.extend(["--preset", "draft", "--device", "cpu", "--mode", scene.mode].map(OsStr::new));
        Ok(self.run(side, &words, self.limits.bake)?.map(|finished| vec![Some(milliseconds(finished.time))]))
    }

    fn first_picture(&self, side: Side, dataset: &Path) -> Result<Result<Figures, String>> {
        let patience = Patience { limit: self.limits.run, stops: &|| self.steps.reporter.cancelled() };
        let display = Display::start().map_err(RunError::Start).and_then(|display| display.ok_or(RunError::NoDisplay));
        let time = display.and_then(|display| display.first_picture(self.program(side), dataset, patience));
        self.steps.check()?;
        Ok(time.map(|time| vec![Some(milliseconds(time))]).map_err(|error| error.to_string()))
    }

    fn bench(
        &self,
        job: &Job,
        side: Side,
        dataset: &Path,
        backend: &str,
        options: &[&[&str]],
    ) -> Result<Result<Figures, String>> {
        let maps = self.data.environment_folder().display().to_string();
        // A program without suns has none to switch off.
        let is_known = |group: &&&[&str]| group[0] != SUN || self.program(side).has(SUN);
        let options = options.iter().filter(is_known).copied().flatten().map(|word| word.replace("{maps}", &maps));
        let mut words: Vec<OsString> = vec!["bench".into(), dataset.into()];
        words.extend(["--json", "--backend", backend].into_iter().chain(COMMON).map(OsString::from));
        words.extend(options.map(OsString::from));
        let printed = self.json(side, &words, self.limits.run)?;
        Ok(printed.map(|printed| job.figures.iter().map(|figure| figure.of(&printed)).collect()))
    }

    /// JSON output of a run.
    fn json(&self, side: Side, words: &[impl AsRef<OsStr>], limit: Duration) -> Result<Result<Value, String>> {
        let finished = self.run(side, words, limit)?;
        Ok(finished.and_then(|run| serde_json::from_str(&run.text).map_err(|error| format!("prints no JSON: {error}"))))
    }

    /// Runs a program; the inner error becomes a remark.
    fn run(&self, side: Side, words: &[impl AsRef<OsStr>], limit: Duration) -> Result<Result<Finished, String>> {
        let patience = Patience { limit, stops: &|| self.steps.reporter.cancelled() };
        let finished = self.program(side).run(words, patience);
        self.steps.check()?;
        Ok(finished.map_err(|error| error.to_string()))
    }

    fn program(&self, side: Side) -> &Program {
        match side {
            Side::This => self.this,
            Side::Other => self.other,
        }
    }

    /// Path of a program's bake of a job's scene.
    fn dataset(&self, job: &Job, baked_by: Side) -> PathBuf {
        self.folder.path().join(format!("{}-{}.cuts", SCENES[job.scene].file, baked_by as usize))
    }
}

/// A requirement of the job that this machine lacks; neither program is at fault.
fn missing_here(work: &Work) -> Option<String> {
    match work {
        Work::Adapter(_) => match DeviceArgs::GPU.gpu() {
            Err(BackendError::NoAdapter { .. }) => Some("there is no graphics adapter".into()),
            _ => None,
        },
        Work::Window => match Display::start() {
            Ok(None) => Some("Xvfb is not installed".into()),
            Ok(Some(_)) => None,
            Err(error) => Some(error.to_string()),
        },
        Work::Bake | Work::Bench(_) => None,
    }
}

fn milliseconds(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

#[cfg(test)]
mod tests;
