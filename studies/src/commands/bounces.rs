//! `lapidary bounces`: errors of each solution of bounced light against light paths, side by side.

use crate::{
    args::{LocalLightArgs, PoseArgs, ViewArgs, ViewedScene, warn_of_buried},
    bounces::{
        BouncedLight,
        light_paths::{Figures, LightPaths},
    },
    ladder::Cuts,
    outputs::{CommandFiles, take_folder},
    sheet::strip,
    terminal::{Console, Outcome, ProgressReporter, StepProgress, write_json},
};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use lapidary_precompute::Observer;
use lapidary_render::{FinishedPicture, Look, RenderStats, Solution};
use serde::Serialize;
use std::path::PathBuf;

/// Options of `bounces`.
#[derive(Args, Clone, Debug)]
pub struct BouncesArgs {
    /// Folder for bounces.json and the pictures
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Light paths per pixel, a multiple of twice --aa; the difference of their halves gives the noise
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    spp: u32,
    /// Merge the stored cuts with an illumination cut of at most this many nodes, instead of lit cuts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: Option<u32>,
    /// Leave out the slowest pictures, with a ray from every pixel to every source
    #[arg(long)]
    no_samples: bool,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    pose: PoseArgs,
}

impl BouncesArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let of = |solution: &Solution| PICTURES.map(|picture| format!("{solution}{picture}"));
        let names = Solution::ALL.iter().flat_map(of).chain([REPORT.into()]);
        self.pose.files(self.view.files(&self.local)).fills(&self.out, names)
    }
}

/// File name of the report.
const REPORT: &str = "bounces.json";
/// Suffixes of a solution's pictures: light paths, the solution, rays to every source, and all side by side.
const PICTURES: [&str; 4] = ["-paths.exr", ".exr", "-every-source.exr", ".png"];

/// Contents of `bounces.json`.
#[derive(Serialize)]
struct Report {
    size: [u32; 2],
    spp: u32,
    #[serde(flatten)]
    cuts: Cuts,
    solutions: Vec<Row>,
}

/// One solution against its reference.
#[derive(Serialize)]
struct Row {
    solution: Solution,
    /// Bounces between surfaces that the paths followed.
    bounces: u32,
    #[serde(flatten)]
    figures: Figures,
    /// Time of the picture alone, on the CPU.
    seconds: f64,
    mean_merged_nodes: f64,
    /// The same light with rays from every pixel to every source instead of cuts.
    every_source: Option<Figures>,
}

/// Pictures in memory at once: both halves of the reference and their mean, the solution, its error, and the sheet.
const PICTURES_AT_ONCE: usize = 8;

/// Renders, traces, compares, and writes the results.
///
/// # Errors
/// Unreadable or unwritable files, a dataset without bounced light, or interruption.
pub fn run(args: &BouncesArgs, console: Console) -> Result<Outcome> {
    if args.local.names_components() {
        bail!("bounces shows bounced light only; leave out --components");
    }
    let interrupt = ProgressReporter::interruptible(console);
    args.view.check_memory(PICTURES_AT_ONCE)?;
    let mut viewed = args.view.resolve(&args.local, console)?;
    viewed.poses = args.pose.read(&viewed.baked.dataset.scene, &args.view.import_options(), console)?;
    let solutions = solutions(&viewed)?;
    if !args.spp.is_multiple_of(2 * viewed.view.aa) {
        bail!("--spp must be a multiple of {}, so that both halves cover the whole pixel", 2 * viewed.view.aa);
    }
    let _taken = take_folder(&args.out)?;
    let mut comparison = Comparison::new(args, &viewed, &interrupt, console)?;
    let mut report = Report { size: viewed.view.size, spp: args.spp, cuts: comparison.cuts, solutions: Vec::new() };
    for solution in solutions {
        let Some(row) = comparison.measure(solution)? else { return Ok(Outcome::Interrupted) };
        console.summary(line(&row))?;
        report.solutions.push(row);
    }
    write_json(&args.out.join(REPORT), &report)?;
    Ok(Outcome::Done)
}

/// The requested solution, or all that the dataset has.
fn solutions(viewed: &ViewedScene) -> Result<Vec<Solution>> {
    if viewed.local.solution.is_some() {
        return Ok(vec![viewed.local.bounces_of(&viewed.baked.dataset)?.1]);
    }
    let solutions = Solution::of(viewed.baked.dataset.bounces());
    if solutions.is_empty() {
        bail!("the dataset has no bounced light; bake it with --mode indirect, meshless or all");
    }
    Ok(solutions)
}

/// Solutions measured one after another.
struct Comparison<'a> {
    args: &'a BouncesArgs,
    cuts: Cuts,
    bounced: BouncedLight,
    no_samples: bool,
    interrupt: &'a ProgressReporter,
    console: Console,
}

impl<'a> Comparison<'a> {
    fn new(
        args: &'a BouncesArgs,
        viewed: &ViewedScene,
        interrupt: &'a ProgressReporter,
        console: Console,
    ) -> Result<Self> {
        let ViewedScene { baked, poses, view, light, local } = viewed;
        let look = Look {
            poses: poses.clone(),
            lights: local.lights.clone().into(),
            ..Look::under_environment(&baked.dataset.scene, view.clone(), light.clone())
        };
        let cuts = args.illum_cut.map_or(Cuts::Lit(look.tau), Cuts::Refine);
        let bounced = BouncedLight::new(baked.clone(), cuts.shown(&look))?;
        warn_of_buried(&bounced.renderer, &local.lights, console);
        // Sources stay at their baked places.
        let no_samples = args.no_samples || !poses.is_empty();
        Ok(Self { args, cuts, bounced, no_samples, interrupt, console })
    }

    /// `None` if interrupted.
    fn measure(&mut self, solution: Solution) -> Result<Option<Row>> {
        let bounces = solution.bounces();
        let FinishedPicture { image, stats, .. } = self.bounced.picture(solution)?;
        let truth = self.light_paths(bounces);
        let samples = if self.no_samples { None } else { self.every_source() };
        if self.interrupt.cancelled() {
            return Ok(None);
        }
        let figures = truth.against(&image)?;
        let every_source = samples.as_ref().map(|samples| truth.against(samples)).transpose()?;
        self.write(solution, &truth.image, &image, samples.as_ref())?;
        let RenderStats { seconds, mean_merged_nodes, .. } = stats;
        Ok(Some(Row { solution, bounces, figures, seconds, mean_merged_nodes, every_source }))
    }

    fn light_paths(&self, bounces: u32) -> LightPaths {
        let progress = self.progress("light paths", "passes");
        let paths = self.bounced.light_paths(self.args.spp, bounces, &progress);
        progress.finish();
        paths
    }

    fn every_source(&self) -> Option<Image> {
        let progress = self.progress("every source", "pixels");
        let image = self.bounced.every_source(&progress);
        progress.finish();
        image
    }

    fn progress(&self, name: &str, unit: &str) -> StepProgress<'_> {
        StepProgress::new(name, unit, self.interrupt, self.console.quiet)
    }

    fn write(&self, solution: Solution, truth: &Image, image: &Image, samples: Option<&Image>) -> Result<()> {
        let file = |what: &str| self.args.out.join(format!("{solution}{what}"));
        let [paths, solved, every_source, strip_of_all] = PICTURES.map(file);
        image::write(truth, &paths)?;
        image::write(image, &solved)?;
        samples.map_or(Ok(()), |samples| image::write(samples, &every_source))?;
        image::write(&strip(truth, &[Some(image), samples])?, &strip_of_all)?;
        Ok(())
    }
}

fn line(row: &Row) -> String {
    let Figures { error, noise, energy, .. } = row.figures;
    let every = row.every_source.map_or(String::new(), |f| format!("; every source {:.4}, {:.3}", f.error, f.energy));
    format!(
        "{:<14} error {error:.4} beside noise of {noise:.4}, energy {energy:.3}, {:.0} nodes, {:.2} s{every}",
        row.solution.to_string(),
        row.mean_merged_nodes,
        row.seconds
    )
}
