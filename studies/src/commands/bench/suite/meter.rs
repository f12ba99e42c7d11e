//! Measures work beside the kernel: the kernel runs before and after every run of the work, so that what slows the machine
//! down slows both.

use super::super::median;
use crate::terminal::Steps;
use anyhow::Result;
use std::time::Duration;

/// Runs of the kernel between two runs of the work.
const KERNELS_BETWEEN: usize = 2;

/// A figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Scene, what was done, and which part of it.
    pub name: String,
    /// Median.
    pub milliseconds: f64,
    /// Its multiple of the median of the kernel's times about it.
    pub kernels: f64,
}

/// All figures so far.
pub struct Meter<'a> {
    kernel: &'a dyn Fn() -> Duration,
    repeats: usize,
    steps: &'a Steps,
    figures: Vec<Figure>,
    kernels: Vec<Duration>,
}

/// What a meter has measured.
pub struct Measured {
    /// In the order of measuring.
    pub figures: Vec<Figure>,
    /// Median milliseconds of the kernel.
    pub kernel: f64,
}

impl<'a> Meter<'a> {
    /// `kernel` runs the kernel and tells its time; `steps` may stop it all.
    pub fn new(kernel: &'a dyn Fn() -> Duration, repeats: usize, steps: &'a Steps) -> Self {
        kernel();
        Self { kernel, repeats, steps, figures: Vec::new(), kernels: Vec::new() }
    }

    /// What tells of progress and stops.
    pub fn steps(&self) -> &'a Steps {
        self.steps
    }

    /// Measures work that tells the times of its parts, a name each: several runs after one to warm up.
    ///
    /// # Errors
    /// Those of the work, or Ctrl-C.
    pub fn measure<const N: usize>(
        &mut self,
        names: [String; N],
        mut work: impl FnMut() -> Result<[Duration; N]>,
    ) -> Result<()> {
        self.steps.begin(&format!("measuring {}", names.join("; ")));
        work()?;
        self.runs(names, self.repeats, work)
    }

    /// Measures one run of work.
    ///
    /// # Errors
    /// Those of the work, or Ctrl-C.
    pub fn measure_once(&mut self, name: String, work: impl FnMut() -> Result<[Duration; 1]>) -> Result<()> {
        self.steps.begin(&format!("measuring {name}"));
        self.runs([name], 1, work)
    }

    fn runs<const N: usize>(
        &mut self,
        names: [String; N],
        repeats: usize,
        mut work: impl FnMut() -> Result<[Duration; N]>,
    ) -> Result<()> {
        let (mut kernels, mut times) = (Vec::new(), Vec::new());
        for _ in 0..repeats {
            self.steps.check()?;
            kernels.extend((0..KERNELS_BETWEEN).map(|_| (self.kernel)()));
            times.push(work()?);
        }
        kernels.extend((0..KERNELS_BETWEEN).map(|_| (self.kernel)()));
        let kernel = median(kernels.clone());
        self.kernels.append(&mut kernels);
        for (part, name) in names.into_iter().enumerate() {
            let milliseconds = median(times.iter().map(|parts| parts[part]).collect());
            self.figures.push(Figure { name, milliseconds, kernels: milliseconds / kernel });
        }
        Ok(())
    }

    /// All figures.
    pub fn finish(self) -> Measured {
        let kernel = if self.kernels.is_empty() { (self.kernel)().as_secs_f64() * 1e3 } else { median(self.kernels) };
        Measured { figures: self.figures, kernel }
    }
}
