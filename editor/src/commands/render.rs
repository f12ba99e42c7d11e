//! `lapidary render`: a picture by merged cuts.

use crate::{
    console::Console,
    outcome::Outcome,
    outputs::{check_folder, check_pictures, write_pictures},
    view_args::{Shot, ViewArgs},
};
use anyhow::Result;
use clap::{Args, ValueEnum};
use lapidary_core::image::Image;
use lapidary_precompute::cli::write_json;
use lapidary_render::{
    Backend, BackendError, BrdfSampling, LightRig, RenderStats, Renderer,
    gpu::{GpuBackend, Room, ShaderSource},
};
use std::{path::PathBuf, sync::Arc, time::Instant};

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
    view: ViewArgs,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum BrdfOption {
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

/// What computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum BackendOption {
    /// The graphics adapter if there is one that is not emulated, else the CPU
    #[default]
    Auto,
    /// The graphics adapter, also an emulated one; an error if there is none
    Gpu,
    /// All cores of this machine
    Cpu,
}

impl BackendOption {
    /// The renderer on the adapter, or `None` for the CPU.
    ///
    /// # Errors
    /// No adapter where one is asked for.
    pub fn gpu(self, console: Console) -> Result<Option<GpuBackend>> {
        let open = || GpuBackend::new(Room::All, &ShaderSource::Embedded);
        match self {
            Self::Cpu => Ok(None),
            Self::Gpu => Ok(Some(open()?)),
            Self::Auto => match open() {
                Ok(gpu) if !gpu.is_software() => Ok(Some(gpu)),
                Ok(_) | Err(BackendError::NoAdapter { .. }) => Ok(None),
                Err(error) => {
                    console.warning(format_args!("rendering on the CPU: {error}"));
                    Ok(None)
                }
            },
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
    let shot = args.view.resolve(console)?;
    let (image, stats) = match args.backend.gpu(console)? {
        Some(gpu) => render_on(gpu, &shot, args)?,
        None => {
            let renderer = Renderer::new(shot.dataset.clone());
            renderer.render(&shot.view, &shot.light, args.illum_cut, args.brdf.into())
        }
    };
    write_pictures(&image, &args.out)?;
    if let Some(path) = &args.stats {
        write_json(path, &stats)?;
    }
    if args.out.is_empty() && args.stats.is_none() {
        console.note("nothing was written; add --out FILE.png or --out FILE.exr");
    }
    console.summary(summary(&args.out, shot.view.size, &stats))?;
    Ok(Outcome::Done)
}

fn render_on(mut gpu: GpuBackend, shot: &Shot, args: &RenderArgs) -> Result<(Image, RenderStats)> {
    gpu.set_scene(&shot.dataset)?;
    let mut rig = LightRig::new(&shot.dataset.tree);
    let start = Instant::now();
    let lighting = Arc::new(rig.lighting(&shot.light, args.illum_cut));
    gpu.set_light(&shot.light, &lighting)?;
    gpu.begin(&shot.view, args.brdf.into())?;
    for sample in 0..shot.view.aa {
        gpu.render_rows(sample, 0..shot.view.size[1])?;
    }
    let seconds = start.elapsed().as_secs_f64();
    let (image, _) = gpu.read(shot.view.aa)?;
    let stats = gpu.stats()?;
    let stats = RenderStats {
        backend: "gpu".into(),
        adapter: Some(gpu.name()),
        seconds,
        pixels_shaded: stats.pixels_shaded,
        mean_merged_nodes: stats.mean_merged_nodes,
        mean_brdf_evaluations: stats.mean_brdf_evaluations,
    };
    Ok((image, stats))
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
