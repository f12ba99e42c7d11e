//! Figures against a baseline, as JSON and as a table.

use super::{baseline::Baseline, kernel, meter::Measured};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Above this ratio to the baseline a figure counts as slower. Runs on a quiet machine differ by a tenth.
const SLOWER: f64 = 1.3;

/// All figures of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Threads that measured.
    threads: usize,
    /// Width and height of the pictures in pixels.
    size: [u32; 2],
    /// All of the run.
    seconds: f64,
    /// [`kernel::VERSION`].
    kernel: u32,
    /// Median.
    kernel_milliseconds: f64,
    /// In the order of measuring.
    pub figures: Vec<ComparedFigure>,
}

/// A figure and that of the baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedFigure {
    /// Scene, what was done, and which part of it.
    pub name: String,
    /// Median.
    pub milliseconds: f64,
    /// Its multiple of the kernel's time.
    pub kernels: f64,
    /// The multiple of the baseline, if it has the figure.
    pub baseline: Option<f64>,
    /// Multiple over that of the baseline.
    pub ratio: Option<f64>,
    /// Whether it is more than 30 % above the baseline.
    pub slower: bool,
}

impl Report {
    /// Compares what was measured.
    pub fn new(size: [u32; 2], time: Duration, measured: Measured, baseline: &Baseline) -> Self {
        let figures = measured.figures.into_iter().map(|figure| {
            let known = baseline.figures.get(&figure.name).copied();
            let ratio = known.map(|known| figure.kernels / known);
            ComparedFigure {
                name: figure.name,
                milliseconds: figure.milliseconds,
                kernels: figure.kernels,
                baseline: known,
                ratio,
                slower: ratio.is_some_and(|ratio| ratio > SLOWER),
            }
        });
        Self {
            threads: rayon::current_num_threads(),
            size,
            seconds: time.as_secs_f64(),
            kernel: kernel::VERSION,
            kernel_milliseconds: measured.kernel,
            figures: figures.collect(),
        }
    }

    /// For people.
    pub fn table(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "{} threads, pictures of {width} x {height}; the kernel takes {:.1} ms; {:.0} s in all\n\n",
            self.threads, self.kernel_milliseconds, self.seconds
        );
        text += &row("figure", ["ms", "kernels", "baseline", "against the baseline"]);
        for f in &self.figures {
            let digits = |value: Option<f64>| value.map_or("new".into(), |value| format!("{value:.3}"));
            let ratio = f.ratio.map_or(String::new(), |r| format!("{r:.2}{}", if f.slower { " slower" } else { "" }));
            let [ms, kernels] = [format!("{:.1}", f.milliseconds), digits(Some(f.kernels))];
            text += &row(&f.name, [&*ms, &*kernels, &*digits(f.baseline), &*ratio]);
        }
        text + "\n" + &self.summary() + "\n"
    }

    fn summary(&self) -> String {
        let slower: Vec<&str> = self.figures.iter().filter(|f| f.slower).map(|f| f.name.as_str()).collect();
        match slower.len() {
            0 if self.figures.iter().all(|f| f.ratio.is_none()) => "The baseline has none of these figures.".into(),
            0 => "No figure is more than 30 % slower than the baseline.".into(),
            n => format!(
                "More than 30 % slower than the baseline ({n} of {}): {}",
                self.figures.len(),
                slower.join("; ")
            ),
        }
    }
}

fn row(name: &str, [ms, kernels, baseline, ratio]: [&str; 4]) -> String {
    format!("{name:<36} {ms:>10} {kernels:>10} {baseline:>10}   {ratio}\n")
}

#[cfg(test)]
mod tests {
    use super::{super::meter::Meter, *};
    use crate::terminal::{Console, Steps};

    /// Figures of work that takes `milliseconds`, on a machine `slowness` times slower than the first.
    fn report(milliseconds: u64, slowness: u32, baseline: &Baseline) -> Report {
        let steps = Steps::new(Console { quiet: true });
        let kernel = || slowness * Duration::from_millis(10);
        let mut meter = Meter::new(&kernel, 3, &steps);
        let [edited, same] = [milliseconds, 40].map(|ms| slowness * Duration::from_millis(ms));
        meter.measure(["edited", "same"].map(Into::into), || Ok([edited, same])).unwrap();
        Report::new([4, 3], Duration::ZERO, meter.finish(), baseline)
    }

    #[test]
    fn what_became_twice_as_slow_is_told_on_any_machine() {
        let first = report(20, 1, &Baseline::default());
        assert!(first.figures.iter().all(|f| f.ratio.is_none()) && first.table().contains("new"));
        assert!(first.table().ends_with("The baseline has none of these figures.\n"));
        let baseline = Baseline::of(&first);
        for slowness in [1, 7] {
            let [same, a_bit, twice] = [20, 25, 40].map(|ms| report(ms, slowness, &baseline));
            assert!(same.figures.iter().all(|f| f.ratio == Some(1.0) && !f.slower));
            assert!(!a_bit.figures[0].slower && a_bit.table().contains("No figure"));
            assert_eq!((twice.figures[0].ratio, twice.figures[0].slower), (Some(2.0), true), "negative control");
            let table = twice.table();
            assert!(table.contains("2.00 slower") && table.ends_with("(1 of 2): edited\n"), "{table}");
        }
    }

    #[test]
    fn reports_and_baselines_survive_json() {
        let first = report(20, 1, &Baseline::default());
        let baseline = Baseline::of(&first);
        let text = serde_json::to_string(&baseline).unwrap();
        assert_eq!(serde_json::from_str::<Baseline>(&text).unwrap(), baseline);
        let second = report(30, 2, &baseline);
        let text = serde_json::to_string(&second).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), second);
        assert_ne!(first, second, "negative control");
    }
}
