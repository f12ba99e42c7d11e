//! `lapidary bounces`: how far each solution of bounced light is from light paths, side by side.

pub mod against_paths;
pub mod strip;

use crate::{
    args::{LocalLightArgs, Shot, ViewArgs, warn_of_buried},
    export::create_folder,
    terminal::{Console, Outcome, ProgressReporter, ProgressStyle, StepProgress, write_json},
    whole_picture::whole_picture,
};
use against_paths::{Figures, Truth};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::image::Image;
use lapidary_precompute::Observer;
use lapidary_render::{
    Backend, Baked, Bounces, BrdfSampling, Components, CpuBackend, LightRig, LocalLighting, LocalRig, PathSettings,
    PictureStats, Renderer, Solution,
};
use serde::Serialize;
use std::{path::PathBuf, sync::Arc, time::Instant};

/// Options of `bounces`.
#[derive(Args, Clone, Debug)]
pub struct BouncesArgs {
    /// Folder for bounces.json and the pictures
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Samples a pixel of the light paths, a multiple of twice --aa; the noise is what their halves differ by
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    spp: u32,
    /// Nodes of the illumination cut
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// Leave out the pictures with a ray from every pixel to every source, which take longest
    #[arg(long)]
    no_samples: bool,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
}

/// What `bounces.json` says.
#[derive(Serialize)]
struct Report {
    size: [u32; 2],
    spp: u32,
    illum_cut: u32,
    solutions: Vec<Row>,
}

/// One solution against its truth.
#[derive(Serialize)]
struct Row {
    solution: Solution,
    /// Bounces between surfaces that the paths followed.
    bounces: u32,
    #[serde(flatten)]
    figures: Figures,
    /// Of the picture alone, on the CPU.
    seconds: f64,
    mean_merged_nodes: f64,
    /// The same light with rays from every pixel to every source in place of the cuts.
    every_source: Option<Figures>,
}

/// Bounced light only: of what else is in a picture, other figures tell.
const INDIRECT: Components = Components { indirect: true, ..Components::NONE };

/// Renders, traces, compares, and writes what was found.
///
/// # Errors
/// Files that cannot be read or written, a dataset without bounced light, and interruption.
pub fn run(args: &BouncesArgs, console: Console) -> Result<Outcome> {
    if args.local.names_components() {
        bail!("bounces shows bounced light only; leave --components out");
    }
    let interrupt = ProgressReporter::new(if console.quiet { ProgressStyle::None } else { ProgressStyle::Bar });
    interrupt.cancel_on_interrupt();
    let shot = args.view.resolve(&args.local, console)?;
    let solutions = solutions(&shot)?;
    if !args.spp.is_multiple_of(2 * shot.view.aa) {
        bail!("--spp must be a multiple of {}: both of its halves sample all of a pixel", 2 * shot.view.aa);
    }
    create_folder(&args.out)?;
    let stage = Stage::new(args, shot, &interrupt, console);
    let mut report =
        Report { size: stage.shot.view.size, spp: args.spp, illum_cut: args.illum_cut, solutions: Vec::new() };
    for solution in solutions {
        let Some(row) = stage.measure(solution)? else { return Ok(Outcome::Interrupted) };
        console.summary(line(&row))?;
        report.solutions.push(row);
    }
    write_json(&args.out.join("bounces.json"), &report)?;
    Ok(Outcome::Done)
}

/// The one asked for, or all that the dataset has.
fn solutions(shot: &Shot) -> Result<Vec<Solution>> {
    if shot.local.solution.is_some() {
        return Ok(vec![shot.local.bounces_of(&shot.dataset)?.1]);
    }
    let solutions = Bounces::of(&shot.dataset).solutions();
    if solutions.is_empty() {
        bail!("the dataset has no bounced light; bake it with --mode indirect, meshless or all");
    }
    Ok(solutions)
}

/// What all solutions share.
struct Stage<'a> {
    args: &'a BouncesArgs,
    shot: Shot,
    baked: Baked,
    renderer: Renderer,
    interrupt: &'a ProgressReporter,
    console: Console,
}

impl<'a> Stage<'a> {
    fn new(args: &'a BouncesArgs, shot: Shot, interrupt: &'a ProgressReporter, console: Console) -> Self {
        let baked = Baked::from(shot.dataset.clone());
        let renderer = Renderer::new(baked.clone());
        warn_of_buried(&renderer, &shot.local.lights, console);
        Self { args, shot, baked, renderer, interrupt, console }
    }

    /// `None` if interrupted.
    fn measure(&self, solution: Solution) -> Result<Option<Row>> {
        let bounces = solution.bounces();
        let lighting = self.lighting(solution);
        let start = Instant::now();
        let (image, stats) = self.picture(&lighting)?;
        let seconds = start.elapsed().as_secs_f64();
        let truth = self.truth(bounces);
        let samples = lighting.indirect.as_ref().filter(|_| !self.args.no_samples).map(|sources| {
            let progress = self.progress("every source", "pixels");
            let image = self.renderer.sources_reference(&self.shot.view, sources, &progress);
            progress.finish();
            image
        });
        if self.interrupt.cancelled() {
            return Ok(None);
        }
        let figures = truth.against(&image)?;
        let every_source = samples.as_ref().map(|samples| truth.against(samples)).transpose()?;
        self.write(solution, &truth.image, &image, samples.as_ref())?;
        let mean_merged_nodes = stats.mean_merged_nodes;
        Ok(Some(Row { solution, bounces, figures, seconds, mean_merged_nodes, every_source }))
    }

    fn picture(&self, lighting: &LocalLighting) -> Result<(Image, PictureStats)> {
        let mut backend = CpuBackend::new();
        backend.set_scene(&self.baked)?;
        backend.set_local_lighting(lighting)?;
        let (image, _) = whole_picture(&mut backend, &self.shot.view, BrdfSampling::default())?;
        Ok((image, backend.stats()?))
    }

    fn lighting(&self, solution: Solution) -> LocalLighting {
        let mut rig = LocalRig::new(&self.baked);
        let environment = LightRig::new(&self.baked.dataset.tree).lighting(&self.shot.light, self.args.illum_cut);
        rig.set_environment(Some(&Arc::new(environment)));
        rig.set_lights(&self.shot.local.lights.clone().into());
        rig.lighting(INDIRECT, solution, self.args.illum_cut)
    }

    fn truth(&self, bounces: u32) -> Truth {
        let progress = self.progress("light paths", "passes");
        let settings = PathSettings { bounces, components: INDIRECT, ..PathSettings::direct(self.args.spp) };
        let Shot { view, light, local, .. } = &self.shot;
        let picture = self.renderer.path_picture(view, light, &local.lights, settings, &progress);
        progress.finish();
        picture.into()
    }

    fn progress(&self, name: &str, unit: &str) -> StepProgress<'_> {
        StepProgress::new(name, unit, self.interrupt, self.console.quiet)
    }

    fn write(&self, solution: Solution, truth: &Image, image: &Image, samples: Option<&Image>) -> Result<()> {
        let file = |what: &str| self.args.out.join(format!("{solution}{what}"));
        truth.write(&file("-paths.exr"))?;
        image.write(&file(".exr"))?;
        samples.map_or(Ok(()), |samples| samples.write(&file("-every-source.exr")))?;
        strip::strip(truth, &[Some(image), samples])?.write(&file(".png"))?;
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
