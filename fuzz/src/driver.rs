//! The driver: starts a worker on each core, for one target after the other, and keeps failing inputs.
//!
//! Workers are processes, so that a worker that aborts, hangs or exhausts its memory ends alone. Target, seed and
//! number determine an input; equal seeds give equal inputs on all machines.

use crate::{
    choices::Choices,
    targets::{self, Target},
    worker::{self, CURRENT, Work},
};
use anyhow::{Context, Result, bail};
use clap::Parser;
use std::{
    collections::BTreeSet,
    fs,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::Mutex,
    time::Instant,
};

/// Number of findings of a target after which its workers are not restarted.
const MOST_FINDINGS: usize = 20;

/// Tries broken inputs on all readers.
#[derive(Parser, Clone, Debug)]
#[command(name = "lapidary-fuzz", max_term_width = 110)]
pub struct Options {
    /// Total number of inputs; slower targets get fewer
    #[arg(long, default_value_t = 100_000)]
    inputs: u64,
    /// Time limit in seconds, shared equally by the targets
    #[arg(long)]
    secs: Option<f64>,
    /// Only this target; may be repeated
    #[arg(long, value_name = "NAME")]
    target: Vec<String>,
    /// Seed of the inputs
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Processes [default: one for each core]
    #[arg(long)]
    workers: Option<usize>,
    /// Folder for failing inputs
    #[arg(long, value_name = "DIR", default_value = "fuzz-findings")]
    findings: PathBuf,
    /// Try only this input, in this process
    #[arg(long, value_name = "NUMBER", requires = "target")]
    input: Option<u64>,
    /// First input of a worker, its step, and its folder; for the driver's own use
    #[arg(long, hide = true, num_args = 3, value_names = ["FIRST", "STEP", "FOLDER"])]
    worker: Option<Vec<String>>,
}

/// Runs the driver.
///
/// # Errors
/// An unknown target, folders that are not writable, or findings.
pub fn run(options: &Options) -> Result<()> {
    let chosen = chosen(&options.target)?;
    match (&options.worker, options.input) {
        (Some(worker), _) => run_worker(&*chosen[0], worker, options),
        (None, Some(number)) => try_one(&*chosen[0], number, options),
        (None, None) => run_all(&chosen, options),
    }
}

fn chosen(names: &[String]) -> Result<Vec<Box<dyn Target>>> {
    let mut all = targets::all();
    let known: Vec<String> = all.iter().map(|target| target.name().to_owned()).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
        bail!("there is no target \"{unknown}\"; choose {}", known.join(", "));
    }
    all.retain(|target| names.is_empty() || names.iter().any(|name| name == target.name()));
    Ok(all)
}

fn run_worker(target: &dyn Target, worker: &[String], options: &Options) -> Result<()> {
    let [first, step, folder] = worker else { bail!("a worker has three values") };
    let work = Work {
        seed: options.seed,
        first: first.parse()?,
        step: step.parse()?,
        end: options.inputs,
        secs: options.secs.unwrap_or(f64::INFINITY),
    };
    worker::run(target, &work, Path::new(folder))
}

fn try_one(target: &dyn Target, number: u64, options: &Options) -> Result<()> {
    let folder = options.findings.join(format!("{}-{}-{number}", target.name(), options.seed));
    fs::create_dir_all(&folder)?;
    target.prepare(&folder)?;
    let bytes = worker::bytes_of(target.name(), options.seed, number);
    let result = worker::attempt(target, &bytes, &folder)?;
    println!("{}: {}", folder.display(), result.err().unwrap_or_else(|| "read or refused".into()));
    Ok(())
}

fn run_all(targets: &[Box<dyn Target>], options: &Options) -> Result<()> {
    let shares: u64 = targets.iter().map(|target| target.share()).sum();
    let began = Instant::now();
    let (mut tried, mut findings) = (0, 0);
    for (i, target) in targets.iter().enumerate() {
        let inputs = (options.inputs * target.share()).div_ceil(shares);
        let left = options.secs.map(|secs| (secs - began.elapsed().as_secs_f64()).max(1.0));
        let secs = left.map(|left| left / (targets.len() - i) as f64);
        let run = Run::new(&**target, Options { inputs, secs, ..options.clone() })?;
        let count = run.run()?;
        tried += count;
        findings += run.finish(count);
    }
    println!("{tried} inputs in {:.0} s, {findings} findings", began.elapsed().as_secs_f64());
    if findings > 0 {
        bail!("there are findings; see the folders ({})", options.findings.display());
    }
    Ok(())
}

/// The run of one target.
struct Run<'a> {
    target: &'a dyn Target,
    /// Options with the inputs and seconds of this target.
    options: Options,
    began: Instant,
    folder: tempfile::TempDir,
    /// Findings without their numbers, so that equal faults count once.
    findings: Mutex<BTreeSet<String>>,
}

impl<'a> Run<'a> {
    fn new(target: &'a dyn Target, options: Options) -> Result<Self> {
        let folder = tempfile::Builder::new().prefix("lapidary-fuzz-").tempdir()?;
        Ok(Self { target, options, began: Instant::now(), folder, findings: Mutex::default() })
    }

    /// Runs workers until all inputs are tried. Returns the number of inputs tried.
    fn run(&self) -> Result<u64> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers = self.options.workers.unwrap_or(cores).max(1) as u64;
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..workers).map(|i| scope.spawn(move || self.tend(i, workers))).collect();
            threads.into_iter().map(|thread| thread.join().expect("a thread that only waits")).sum()
        })
    }

    /// Starts a worker for every `step`th input, and again after each input that ends it.
    fn tend(&self, start: u64, step: u64) -> Result<u64> {
        let folder = self.folder.path().join(start.to_string());
        fs::create_dir(&folder)?;
        let (mut first, mut tried) = (start, 0);
        while first < self.options.inputs && !self.full() {
            let (count, fault) = self.start_worker(first, step, &folder)?;
            tried += count;
            let Some(fault) = fault else { break };
            let Ok(at) = fs::read_to_string(folder.join(CURRENT)) else {
                bail!("a worker of {} ended before its first input: {fault}", self.target.name())
            };
            let at: u64 = at.parse()?;
            self.keep(at, &fault)?;
            tried += (at - first) / step + 1;
            first = at + step;
        }
        Ok(tried)
    }

    /// Runs one worker. Returns the number of inputs it tried and, unless it finished, how it ended.
    fn start_worker(&self, first: u64, step: u64, folder: &Path) -> Result<(u64, Option<String>)> {
        let _ = fs::remove_file(folder.join(CURRENT));
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["--target", self.target.name(), "--seed", &self.options.seed.to_string()]);
        command.args(["--inputs", &self.options.inputs.to_string()]);
        if let Some(secs) = self.options.secs {
            command.args(["--secs", &(secs - self.began.elapsed().as_secs_f64()).max(0.1).to_string()]);
        }
        command.arg("--worker").args([first.to_string(), step.to_string()]).arg(folder);
        let errors = folder.join("standard-error");
        command.env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped()).stderr(fs::File::create(&errors)?);
        let mut worker = command.spawn().context("the driver cannot start itself")?;
        let mut tried = 0;
        for line in BufReader::new(worker.stdout.take().context("a pipe")?).lines() {
            let line = line?;
            match line.split_once(' ') {
                Some(("tried", count)) => tried = count.parse()?,
                Some(("finding", rest)) => {
                    let (number, text) = rest.split_once(' ').context("a finding has a number")?;
                    self.keep(number.parse()?, text)?;
                }
                _ => {}
            }
        }
        let status = worker.wait()?;
        let errors = fs::read_to_string(errors).unwrap_or_default();
        Ok((tried, (!status.success()).then(|| format!("{status}: {}", errors.lines().next().unwrap_or_default()))))
    }

    /// Keeps an input, remade from its number, unless an equal finding exists.
    fn keep(&self, number: u64, finding: &str) -> Result<()> {
        let alike: String = finding.chars().filter(|c| !c.is_ascii_digit()).take(160).collect();
        if !self.findings.lock().expect("no thread panics with it").insert(alike) {
            return Ok(());
        }
        let name = self.target.name();
        let kept = self.options.findings.join(format!("{name}-{}-{number}", self.options.seed));
        fs::create_dir_all(&kept)?;
        self.target.prepare(&kept)?;
        let bytes = worker::bytes_of(name, self.options.seed, number);
        self.target.write(&mut Choices::new(&bytes), &kept)?;
        fs::write(kept.join("finding.txt"), format!("{finding}\n"))?;
        println!("  {}: {finding}", kept.display());
        Ok(())
    }

    fn full(&self) -> bool {
        self.findings.lock().expect("no thread panics with it").len() >= MOST_FINDINGS
    }

    /// Prints a line about the target; returns the number of its findings.
    fn finish(&self, count: u64) -> usize {
        let (secs, findings) =
            (self.began.elapsed().as_secs_f64(), self.findings.lock().map_or(0, |found| found.len()));
        println!("{:<11} {count:>8} inputs in {secs:>6.1} s, {findings} findings", self.target.name());
        findings
    }
}
