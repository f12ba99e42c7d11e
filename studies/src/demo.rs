//! `lapidary demo`: all steps on bundled data, with a report.

mod bake;
mod gallery;
mod ladder;
mod page;
mod pictures;
mod report;

use crate::{
    bundled::DataFolder,
    outputs::{CommandFiles, take_folder},
    terminal::{Console, Outcome, Steps, write_json},
};
use anyhow::{Context, Result};
use clap::Args;
use lapidary_core::output::write_atomically;
use lapidary_precompute::verify;
use pictures::{Picture, StillLife};
use report::Report;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

/// Options of `demo`.
#[derive(Args, Clone, Debug)]
pub struct DemoArgs {
    /// Folder for pictures, report.json and report.html; it is created if missing
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
    /// Folder with the bundled scenes and environments [default: in the source tree]
    #[arg(long, value_name = "DIR", env = "LAPIDARY_DATA", hide_env_values = true)]
    data: Option<PathBuf>,
}

impl DemoArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let pictures = ["png", "exr"].map(|extension| pictures::NAMES.map(|name| format!("{name}.{extension}")));
        let names = ["report.json", "report.html", bake::DATASET, "error-*.png"].map(String::from);
        CommandFiles::default().reads(&self.data).fills(&self.out, pictures.into_iter().flatten().chain(names))
    }
}

/// Vertices to retrace after the bake.
const VERIFIED_VERTICES: usize = 64;

/// Bakes, renders, traces, compares and reports.
///
/// # Errors
/// Missing data, an unwritable folder, or Ctrl-C.
pub fn run(args: &DemoArgs, console: Console) -> Result<Outcome> {
    let start = Instant::now();
    let data = DataFolder::find(args.data.as_deref())?;
    let _taken = take_folder(&args.out)?;
    let steps = Steps::new(console);
    let environments = data.environments(console)?;
    let dataset = Arc::new(bake::bake_still_life(&data, &args.out, &steps)?);
    let verification = verify(&dataset, VERIFIED_VERTICES);
    let mut still_life = StillLife::new(&dataset, &environments, &args.out)?;
    let gallery = gallery::take(&mut still_life, environments.names(), &steps)?;
    let ladder = ladder::climb(&mut still_life, &steps)?;
    let report = Report::new(&dataset, verification, gallery, ladder, start.elapsed().as_secs_f64());
    write_report(&report, &args.out)?;
    console.summary(format_args!("{:.0} s; open {}", report.seconds, args.out.join("report.html").display()))?;
    Ok(Outcome::Done)
}

fn write_report(report: &Report, out: &Path) -> Result<()> {
    write_json(&out.join("report.json"), report)?;
    let page = out.join("report.html");
    write_atomically(&page, page::page(report).as_bytes())
        .with_context(|| format!("cannot write the report; check the free space ({})", page.display()))
}
