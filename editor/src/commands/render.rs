//! `lapidary render`: a picture by merged cuts.

use crate::{
    backend_option::BackendOption,
    console::Console,
    outcome::Outcome,
    outputs::{check_folder, check_pictures, write_pictures},
    view_args::{LocalLightArgs, Shot, ViewArgs, warn_of_buried},
};
use anyhow::Result;
use clap::{Args, ValueEnum};
use lapidary_core::image::Image;
use lapidary_precompute::cli::write_json;
use lapidary_render::{
    Backend, Background, Baked, BrdfSampling, CPU, Components, LightRig, LocalRig, RenderStats, Renderer, Solution,
};
use std::{path::PathBuf, sync::Arc, time::Instant};

/// Rows that are rendered at once: drivers stop work that holds up a graphics adapter for seconds, as the whole of a large
/// picture with thousands of lights may.
const BAND_ROWS: usize = 64;

/// Options of `render`.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// Most nodes of the illumination cut, 1 to 32768: more follow small lights more closely, and cost time
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// How the BRDF is sampled
    #[arg(long, value_enum, default_value_t)]
    brdf: BrdfOption,
    /// What computes
    #[arg(long, value_enum, default_value_t)]
    backend: BackendOption,
    /// Picture to write: .exr or .hdr (scene-linear), .png (sRGB, clamped); may be given several times
    #[arg(long, value_name = "FILE")]
    out: Vec<PathBuf>,
    /// Write times and counts as JSON
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
}

/// How the BRDF is sampled, as an option.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum BrdfOption {
    /// Halve nodes that are wider than the lobe can bear, during the merge
    #[default]
    Refine,
    /// Once for each node of the merged cut, as in the paper
    Once,
}

impl From<BrdfOption> for BrdfSampling {
    fn from(option: BrdfOption) -> Self {
        match option {
            BrdfOption::Refine => Self::Refine,
            BrdfOption::Once => Self::Once,
        }
    }
}

/// Renders and writes the picture.
///
/// # Errors
/// Files that cannot be read or written, options that contradict each other.
pub fn run(args: &RenderArgs, console: Console) -> Result<Outcome> {
    check_pictures(&args.out)?;
    args.stats.iter().try_for_each(|path| check_folder(path))?;
    let shot = args.view.resolve(&args.local, console)?;
    let bounces = shot.local.bounces_of(&shot.dataset)?;
    let mut backend = args.backend.open()?;
    let (image, coverage, stats) = render_on(&mut *backend, &shot, bounces, args, console)?;
    let transparent = shot.view.background == Background::Transparent;
    write_pictures(&image, transparent.then_some(coverage.as_slice()), &args.out)?;
    if let Some(path) = &args.stats {
        write_json(path, &stats)?;
    }
    if args.out.is_empty() && args.stats.is_none() {
        console.note("nothing was written; add --out FILE.png or --out FILE.exr");
    }
    console.summary(summary(&args.out, shot.view.size, &stats))?;
    Ok(Outcome::Done)
}

/// The picture, its coverage, and how it was made.
fn render_on(
    backend: &mut dyn Backend,
    shot: &Shot,
    (components, solution): (Components, Solution),
    args: &RenderArgs,
    console: Console,
) -> Result<(Image, Vec<f32>, RenderStats)> {
    let baked = Baked::from(shot.dataset.clone());
    backend.set_scene(&baked)?;
    let mut rig = LightRig::new(&shot.dataset.tree);
    let mut local = LocalRig::new(&baked);
    warn_of_buried(&Renderer::new(baked), &shot.local.lights, console);
    let start = Instant::now();
    let lighting = Arc::new(rig.lighting(&shot.light, args.illum_cut));
    tell(backend.set_light(&shot.light, &lighting)?, console);
    local.set_environment(Some(&lighting));
    local.set_lights(&shot.local.lights.clone().into());
    tell(backend.set_local_lighting(&local.lighting(components, solution, args.illum_cut))?, console);
    backend.begin(&shot.view, args.brdf.into())?;
    for sample in 0..shot.view.aa {
        let height = shot.view.size[1];
        for first in (0..height).step_by(BAND_ROWS) {
            backend.render_rows(sample, first..height.min(first + BAND_ROWS as u32))?;
        }
    }
    let (image, coverage) = backend.read(shot.view.aa)?;
    let seconds = start.elapsed().as_secs_f64();
    let done = backend.stats()?;
    let on_gpu = backend.name() != CPU;
    let stats = RenderStats {
        backend: if on_gpu { "gpu" } else { "cpu" }.into(),
        adapter: on_gpu.then(|| backend.name()),
        seconds,
        pixels_shaded: done.pixels_shaded,
        mean_merged_nodes: done.mean_merged_nodes,
        mean_brdf_evaluations: done.mean_brdf_evaluations,
    };
    Ok((image, coverage, stats))
}

fn tell(remarks: Vec<String>, console: Console) {
    remarks.iter().for_each(|remark| console.warning(remark));
}

fn summary(out: &[PathBuf], [width, height]: [u32; 2], stats: &RenderStats) -> String {
    let names: Vec<String> = out.iter().map(|p| format!("{}: ", p.display())).collect();
    format!(
        "{}{width} x {height} in {:.2} s, {:.0} merged nodes and {:.0} BRDF evaluations a sample",
        names.concat(),
        stats.seconds,
        stats.mean_merged_nodes,
        stats.mean_brdf_evaluations
    )
}
