//! `lapidary reference`: a picture by ray tracing.

use crate::{
    args::{LocalLightArgs, PoseArgs, ViewArgs, ViewedScene, choices, warn_of_buried},
    export::{check_pictures, write_pictures},
    ladder::{BOUNCES_AS_BAKED, every_sample},
    outputs::CommandFiles,
    terminal::{Console, Outcome, ProgressReporter, StepProgress},
};
use anyhow::{Context as _, Result, bail};
use clap::{Args, ValueEnum};
use lapidary_core::{image::Image, scene::pose::Poses};
use lapidary_precompute::Observer;
use lapidary_render::{Components, Look, PathSettings, Renderer, SamplePositions};
use std::{path::PathBuf, time::Instant};

/// Options of `reference`.
#[derive(Args, Clone, Debug)]
pub struct ReferenceArgs {
    /// Kind of reference
    #[arg(long, value_enum, default_value_t)]
    kind: Kind,
    /// Samples per pixel of --kind path, 1 to 1000000 [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    spp: Option<u32>,
    /// Most bounces of light between surfaces with --kind path, 0 to 1000; 1 is direct light and one indirect bounce
    /// [default: 0; 1 if --components names indirect]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    bounces: Option<u32>,
    /// Seed of the random light paths of --kind path, 0 to 4000; each gives other noise [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=4000))]
    seed: Option<u32>,
    /// Where in a pixel the light paths of --kind path start [default: shared]
    #[arg(long, value_parser = choices::sample_positions())]
    places: Option<SamplePositions>,
    /// Picture to write: .exr or .hdr (scene-linear), .png (sRGB, clamped); may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    pose: PoseArgs,
}

impl ReferenceArgs {
    /// Files that it reads and writes.
    ///
    /// # Errors
    /// A picture of unknown format.
    pub fn files(&self) -> Result<CommandFiles> {
        check_pictures(&self.out)?;
        Ok(self.pose.files(self.view.files(&self.local)).writes(&self.out))
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A ray to every light sample of the dataset at every pixel: shows the error of the cuts
    #[default]
    Samples,
    /// Light paths from the continuous environment and from local lights by multiple importance sampling, with any
    /// number of bounces: shows the whole error, with some noise
    Path,
}

/// Default samples per pixel: as noisy as a clean preview.
const DEFAULT_SPP: u32 = 64;

/// Traces and writes the picture, or its finished part at Ctrl-C.
///
/// # Errors
/// Unreadable or unwritable files, or contradictory options.
pub fn run(args: &ReferenceArgs, console: Console) -> Result<Outcome> {
    if args.kind == Kind::Samples && args.spp.is_some() {
        bail!("--spp goes with --kind path; --kind samples traces every light sample once");
    }
    if args.kind == Kind::Samples && args.bounces.is_some() {
        bail!("--bounces goes with --kind path; --kind samples traces no light paths");
    }
    if args.kind == Kind::Samples && args.seed.is_some() {
        bail!("--seed goes with --kind path; --kind samples has no noise");
    }
    if args.kind == Kind::Samples && args.places.is_some() {
        bail!("--places goes with --kind path; --kind samples uses those of `render`");
    }
    let interrupt = ProgressReporter::interruptible(console);
    let mut viewed = args.view.resolve(&args.local, console)?;
    if args.kind == Kind::Path {
        viewed.view.aa = args.view.smooth_samples(&viewed.view.camera);
    }
    viewed.poses = args.pose.read(&viewed.baked.dataset.scene, &args.view.import_options(), console)?;
    let posed = viewed.baked.posed(&viewed.poses).context("the objects cannot be posed this way")?;
    if args.kind == Kind::Samples && viewed.local.components.is_some_and(|c| c.indirect) {
        if !viewed.poses.is_empty() {
            bail!("{BOUNCES_AS_BAKED}; use --kind path");
        }
        let (_, solution) = viewed.local.bounces_of(&viewed.baked.dataset)?;
        if !solution.needs().sources() {
            bail!(
                "--kind samples shows bounced light of surface sources only; use --kind path, or bake with --mode all"
            );
        }
    }
    let start = Instant::now();
    let image = trace(args, &ViewedScene { baked: posed, poses: Poses::default(), ..viewed }, &interrupt, console)?;
    write_pictures(&image, None, &args.out)?;
    let names: Vec<String> = args.out.iter().map(|p| p.display().to_string()).collect();
    if interrupt.cancelled() {
        console.note(format_args!("stopped early: the picture is unfinished ({})", names.join(", ")));
        return Ok(Outcome::Interrupted);
    }
    console.summary(format_args!("{}: {:.1} s", names.join(", "), start.elapsed().as_secs_f64()))?;
    Ok(Outcome::Done)
}

fn trace(args: &ReferenceArgs, viewed: &ViewedScene, interrupt: &ProgressReporter, console: Console) -> Result<Image> {
    let renderer = Renderer::new(viewed.baked.clone());
    warn_of_buried(&renderer, &viewed.local.lights, console);
    let progress = |unit| StepProgress::new("reference", unit, interrupt, console.quiet);
    match args.kind {
        Kind::Samples => {
            let progress = progress("pixels");
            let image = every_sample(&viewed.baked, &unbounced(viewed)?, &renderer, &progress);
            progress.finish();
            image
        }
        Kind::Path => {
            let progress = progress("passes");
            let image = renderer.path_reference(
                &viewed.view,
                &viewed.light,
                &viewed.local.lights,
                path_settings(args, viewed),
                &progress,
            );
            progress.finish();
            Ok(image)
        }
    }
}

/// The look without bounced light, unless requested: it takes a ray from every pixel to every source.
fn unbounced(viewed: &ViewedScene) -> Result<Look> {
    let components = viewed.local.components.unwrap_or(Components::UNBOUNCED);
    Ok(Look { components, ..viewed.look()? })
}

/// Path settings; they include bounces if requested by number or as a component.
fn path_settings(args: &ReferenceArgs, viewed: &ViewedScene) -> PathSettings {
    let components = viewed.local.components.unwrap_or(Components::ALL);
    let default = u32::from(viewed.local.components.is_some_and(|c| c.indirect));
    let bounces = args.bounces.unwrap_or(default);
    let spp = args.spp.unwrap_or(DEFAULT_SPP);
    let first_pass = args.seed.unwrap_or(0) * spp.max(viewed.view.aa);
    let positions = args.places.unwrap_or_default();
    PathSettings { spp, first_pass, bounces, components, positions }
}
