//! `lapidary bench --suite`: how long bake, frame, drag, orbit, rotation and lit cuts take on the bundled scenes, in
//! milliseconds and in multiples of a fixed piece of work ([`kernel`]). The multiples depend little on the machine and on
//! what else runs there, so they are held against a stored baseline.

mod baseline;
mod figures;
mod kernel;
mod meter;
mod report;
mod scenes;

use super::PICTURE;
use crate::{
    bundled::DataFolder,
    outputs::CommandFiles,
    terminal::{Console, Steps, json_text, print_out, write_json},
};
use anyhow::{Context, Result};
use baseline::Baseline;
use clap::Args;
use kernel::Kernel;
use meter::Meter;
use report::Report;
use scenes::Plan;
use std::{path::PathBuf, time::Instant};

/// Options of the suite.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Suite on the bundled scenes")]
pub struct SuiteArgs {
    /// Measure bake, frame, drag, rotation and lit cuts on the bundled scenes, on the CPU, in place of a dataset's frames
    #[arg(long, conflicts_with_all = PICTURE, conflicts_with_all = ["file", "surfels", "PassesArgs"])]
    suite: bool,
    /// Baseline to compare with [default: the one that comes with this version]
    #[arg(long, value_name = "FILE.json", requires = "suite", conflicts_with = "file")]
    baseline: Option<PathBuf>,
    /// Write the figures as a new baseline
    #[arg(long, value_name = "FILE.json", requires = "suite", conflicts_with = "file")]
    save: Option<PathBuf>,
    /// Folder with the bundled scenes and environments [default: that of the source tree]
    #[arg(long, value_name = "DIR", env = "LAPIDARY_DATA", hide_env_values = true)]
    data: Option<PathBuf>,
}

impl SuiteArgs {
    /// What it reads and writes.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().reads(&self.data).reads(&self.baseline).writes(&self.save)
    }
}

/// How large and how often everything is measured.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// Size of the pictures in pixels.
    size: [u32; 2],
    /// Light samples and surface sources of the bakes, which then add no vertices; `None` bakes drafts.
    lights: Option<usize>,
    /// Runs of each figure but the bakes, after one to warm up.
    repeats: usize,
    /// Pixels of the kernel.
    kernel_pixels: u32,
}

impl Scale {
    /// The paper's size of pictures; four minutes on two cores.
    const FULL: Self = Self { size: [640, 480], lights: None, repeats: 5, kernel_pixels: kernel::PIXELS };
}

/// Measures, compares and prints.
///
/// # Errors
/// A baseline or bundled data that cannot be read, a file that cannot be written, or Ctrl-C.
pub fn run(args: &SuiteArgs, json: bool, console: Console) -> Result<()> {
    let baseline = args.baseline.as_deref().map_or_else(Baseline::stored, Baseline::read)?;
    let data = DataFolder::find(args.data.as_deref())?;
    let steps = Steps::new(console);
    let report = measure(&scenes::PLANS, &data, &Scale::FULL, &baseline, &steps)?;
    if let Some(path) = &args.save {
        write_json(path, &Baseline::of(&report))?;
    }
    print_out(&if json { json_text(&report)? } else { report.table() })
}

/// All figures of `plans`, against `baseline`.
fn measure(plans: &[Plan], data: &DataFolder, scale: &Scale, baseline: &Baseline, steps: &Steps) -> Result<Report> {
    let start = Instant::now();
    let kernel = Kernel::new(scale.kernel_pixels);
    let time = || kernel.time();
    let mut meter = Meter::new(&time, scale.repeats, steps);
    let folder = tempfile::tempdir().context("cannot bake to the folder for temporary files; check its free space")?;
    for plan in plans {
        let case = plan.bake(data, folder.path(), scale, &mut meter)?;
        figures::measure(&case, &mut meter)?;
    }
    Ok(Report::new(scale.size, start.elapsed(), meter.finish(), baseline))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colour box has the fewest vertices.
    #[test]
    fn a_small_suite_measures_a_scene_and_has_a_stored_baseline() {
        let scale = Scale { size: [16, 12], lights: Some(64), repeats: 1, kernel_pixels: 64 };
        let (data, steps) = (DataFolder::find(None).unwrap(), Steps::new(Console { quiet: true }));
        let plans = &scenes::PLANS[2..];
        let report = measure(plans, &data, &scale, &Baseline::default(), &steps).unwrap();
        let names: Vec<&str> = report.figures.iter().map(|figure| figure.name.as_str()).collect();
        let parts = [
            "bake",
            "frame, lit",
            "frame, refine",
            "frame, once",
            "drag, first sketch",
            "drag, finished",
            "orbit, first sketch",
            "orbit, finished",
            "lit cuts, sources",
        ];
        assert_eq!(names, parts.map(|part| format!("color-box: {part}")));
        assert!(report.figures.iter().all(|f| f.milliseconds > 0.0 && f.kernels.is_finite() && f.ratio.is_none()));
        let drag = |part: usize| report.figures[part].milliseconds;
        assert!(drag(4) < drag(5), "the sketch comes first");
        let stored = Baseline::stored().unwrap();
        let of_this = |name: &&String| name.starts_with("color-box: ");
        assert_eq!(stored.figures.keys().filter(of_this).count(), names.len());
        for baseline in [stored, Baseline::of(&report)] {
            assert!(names.iter().all(|&name| baseline.figures.contains_key(name)));
        }
    }

    #[test]
    fn the_stored_baseline_is_of_these_scenes() {
        let of_a_scene = |name: &String| scenes::PLANS.iter().any(|plan| name.starts_with(&format!("{}: ", plan.name)));
        assert!(Baseline::stored().unwrap().figures.keys().all(of_a_scene));
    }
}
