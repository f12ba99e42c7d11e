//! A process that tries one input after another. Its parent notices when it dies.

use crate::{MOST_SECS, choices::Choices, limit_memory, targets::Target};
use anyhow::{Context, Result};
use std::{
    fs,
    panic::{self, AssertUnwindSafe},
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

/// File in a worker's folder with the number of its current input.
pub const CURRENT: &str = "current-input";

/// The inputs of a worker.
#[derive(Clone, Debug)]
pub struct Work {
    /// Seed, which determines all inputs together with their numbers.
    pub seed: u64,
    /// Number of the first input.
    pub first: u64,
    /// Step between inputs.
    pub step: u64,
    /// One past the last possible input.
    pub end: u64,
    /// Seconds after which no input begins.
    pub secs: f64,
}

/// The bytes that determine input `number` of a target.
pub fn bytes_of(target: &str, seed: u64, number: u64) -> Vec<u8> {
    let name = blake3::hash(format!("{target} {seed} {number}").as_bytes());
    let mut random = fastrand::Rng::with_seed(u64::from_le_bytes(name.as_bytes()[..8].try_into().unwrap_or_default()));
    let length = random.usize(8..160);
    (0..length).map(|_| random.u8(..)).collect()
}

/// Tries inputs in `folder`. Prints `finding NUMBER TEXT` for each finding, and at the end `tried COUNT`.
///
/// # Errors
/// A folder that is not writable.
pub fn run(target: &dyn Target, work: &Work, folder: &Path) -> Result<()> {
    let began = Instant::now();
    target.prepare(folder).context("the folder of a worker must be writable")?;
    silence_panics();
    // One-time initialization does not count.
    let _ = attempt(target, &[], folder);
    limit_memory();
    let watch = Watch::start();
    let mut tried = 0;
    let numbers = (work.first..work.end).step_by(usize::try_from(work.step)?);
    for number in numbers.take_while(|_| began.elapsed().as_secs_f64() < work.secs) {
        fs::write(folder.join(CURRENT), number.to_string())?;
        let bytes = bytes_of(target.name(), work.seed, number);
        watch.begin();
        let (result, mut secs) = timed_attempt(target, &bytes, folder)?;
        if secs > MOST_SECS {
            // Other programs may have delayed it.
            watch.begin();
            secs = secs.min(timed_attempt(target, &bytes, folder)?.1);
        }
        watch.end();
        tried += 1;
        let slow = (secs > MOST_SECS).then(|| format!("it took {secs:.1} s"));
        if let Some(finding) = result.err().or(slow) {
            println!("finding {number} {}", finding.replace('\n', " "));
        }
    }
    println!("tried {tried}");
    Ok(())
}

/// The reader's fault on one input, and the seconds taken.
fn timed_attempt(target: &dyn Target, bytes: &[u8], folder: &Path) -> Result<(Result<(), String>, f64)> {
    let began = Instant::now();
    let result = attempt(target, bytes, folder)?;
    Ok((result, began.elapsed().as_secs_f64()))
}

/// Tries one input. The inner result is the reader's fault, which may be a panic.
///
/// # Errors
/// A folder that is not writable.
pub fn attempt(target: &dyn Target, bytes: &[u8], folder: &Path) -> Result<Result<(), String>> {
    target.write(&mut Choices::new(bytes), folder)?;
    let read = panic::catch_unwind(AssertUnwindSafe(|| target.read(folder)));
    Ok(read.unwrap_or_else(|_| Err(PANIC.lock().map(|text| format!("panic: {text}")).unwrap_or_default())))
}

/// Text of the last panic.
static PANIC: Mutex<String> = Mutex::new(String::new());

fn silence_panics() {
    panic::set_hook(Box::new(|info| {
        if let Ok(mut text) = PANIC.lock() {
            *text = info.to_string();
        }
    }));
}

/// Ends the process if an input takes twice its time limit.
struct Watch {
    began: Instant,
    /// Start of the current input in milliseconds, and 0 between inputs.
    input: &'static AtomicU64,
}

impl Watch {
    fn start() -> Self {
        static INPUT: AtomicU64 = AtomicU64::new(0);
        let began = Instant::now();
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(Duration::from_millis(200));
                let input = INPUT.load(Ordering::Relaxed);
                let limit = 2000.0 * MOST_SECS;
                if input > 0 && began.elapsed().as_millis() as f64 > input as f64 + limit {
                    eprintln!("it takes longer than {} s", 2.0 * MOST_SECS);
                    std::process::abort();
                }
            }
        });
        Self { began, input: &INPUT }
    }

    fn begin(&self) {
        self.input.store(self.began.elapsed().as_millis() as u64 + 1, Ordering::Relaxed);
    }

    fn end(&self) {
        self.input.store(0, Ordering::Relaxed);
    }
}
