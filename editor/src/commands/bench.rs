//! `lapidary bench`: how long each pass of a frame takes.

use crate::{
    backend_option::BackendOption,
    console::Console,
    outcome::Outcome,
    view_args::{Shot, ViewArgs},
};
use anyhow::Result;
use clap::Args;
use lapidary_precompute::cli::print_out;
use lapidary_render::{
    Backend, BrdfSampling, LightRig, Post, Renderer,
    gpu::{GpuBackend, PassTimes},
};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    sync::Arc,
    time::{Duration, Instant},
};

/// Options of `bench`.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// Sizes of the illumination cut, separated by commas
    #[arg(long, value_name = "K,..", value_delimiter = ',', default_values_t = [128, 256, 512],
          value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cuts: Vec<u32>,
    /// Frames to take the median of, after one to warm up
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// What computes
    #[arg(long, value_enum, default_value_t)]
    backend: BackendOption,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    view: ViewArgs,
}

/// All figures.
#[derive(Debug, Serialize)]
struct Bench {
    /// `cpu`, or the adapter's name.
    adapter: String,
    size: [u32; 2],
    vertices: usize,
    triangles: usize,
    mean_cut: f64,
    lights: usize,
    frames: u32,
    /// From a turned environment to a new illumination cut of 256: leaf radiance, tree and cut, on one thread.
    rotation_milliseconds: f64,
    runs: Vec<Run>,
}

/// Figures of one illumination cut.
#[derive(Debug, Serialize)]
struct Run {
    illum_cut: u32,
    /// Medians by pass, and `total`.
    milliseconds: BTreeMap<&'static str, f64>,
    mean_merged_nodes: f64,
    mean_brdf_evaluations: f64,
}

/// Measures and prints.
///
/// # Errors
/// Files that cannot be read, or no adapter where one is asked for.
pub fn run(args: &BenchArgs, console: Console) -> Result<Outcome> {
    let shot = args.view.resolve(console)?;
    let gpu = args.backend.gpu()?;
    let adapter = gpu.as_ref().map_or("cpu".to_owned(), Backend::name);
    let runs = match gpu {
        Some(gpu) => gpu_runs(args, &shot, gpu)?,
        None => args.illum_cuts.iter().map(|&k| cpu_run(args, &shot, k)).collect(),
    };
    let bench = Bench {
        adapter,
        size: shot.view.size,
        vertices: shot.dataset.scene.mesh.positions.len(),
        triangles: shot.dataset.scene.mesh.triangles.len(),
        mean_cut: shot.dataset.report.mean_cut,
        lights: shot.dataset.tree.len(),
        frames: args.frames,
        rotation_milliseconds: rotation(&shot, args.frames),
        runs,
    };
    if args.json {
        print_out(&format!("{}\n", serde_json::to_string_pretty(&bench)?))?;
    } else {
        print_out(&table(&bench))?;
    }
    Ok(Outcome::Done)
}

fn gpu_runs(args: &BenchArgs, shot: &Shot, mut gpu: GpuBackend) -> Result<Vec<Run>> {
    let mut rig = LightRig::new(&shot.dataset.tree);
    gpu.set_scene(&shot.dataset.clone().into())?;
    let mut runs = Vec::new();
    for &illum_cut in &args.illum_cuts {
        let lighting = Arc::new(rig.lighting(&shot.light, illum_cut));
        gpu.set_light(&shot.light, &lighting)?;
        gpu.begin(&shot.view, BrdfSampling::Refine)?;
        gpu.timed_sample(0, &Post::default())?;
        let times = (0..args.frames).map(|_| gpu.timed_sample(0, &Post::default()));
        let times = times.collect::<Result<Vec<_>, _>>()?;
        gpu.begin(&shot.view, BrdfSampling::Refine)?;
        gpu.render_rows(0, 0..shot.view.size[1])?;
        let stats = gpu.stats()?;
        runs.push(Run {
            illum_cut,
            milliseconds: medians(&times),
            mean_merged_nodes: stats.mean_merged_nodes,
            mean_brdf_evaluations: stats.mean_brdf_evaluations,
        });
    }
    Ok(runs)
}

fn medians(times: &[PassTimes]) -> BTreeMap<&'static str, f64> {
    let pass = |of: fn(&PassTimes) -> Duration| median(times.iter().map(of).collect());
    BTreeMap::from([
        ("visibility", pass(|t| t.visibility)),
        ("deferred", pass(|t| t.deferred)),
        ("merge", pass(|t| t.merge)),
        ("display", pass(|t| t.display)),
        ("total", pass(|t| t.visibility + t.deferred + t.merge + t.display)),
    ])
}

fn cpu_run(args: &BenchArgs, shot: &Shot, illum_cut: u32) -> Run {
    let renderer = Renderer::new(shot.dataset.clone());
    let lighting = renderer.lighting(&shot.light, illum_cut);
    let frame = || {
        let start = Instant::now();
        let (_, stats) = renderer.render_lit(&shot.view, &shot.light, &lighting, BrdfSampling::Refine);
        (start.elapsed(), stats)
    };
    let (_, stats) = frame();
    let total = median((0..args.frames).map(|_| frame().0).collect());
    Run {
        illum_cut,
        milliseconds: BTreeMap::from([("total", total)]),
        mean_merged_nodes: stats.mean_merged_nodes,
        mean_brdf_evaluations: stats.mean_brdf_evaluations,
    }
}

/// Median milliseconds from a turned environment to nodes and illumination cut.
fn rotation(shot: &Shot, frames: u32) -> f64 {
    let mut rig = LightRig::new(&shot.dataset.tree);
    let mut light = shot.light.clone();
    rig.lighting(&light, 256);
    let times = (0..frames).map(|_| {
        light.rotation += 0.01;
        let start = Instant::now();
        rig.lighting(&light, 256);
        start.elapsed()
    });
    median(times.collect())
}

/// In milliseconds.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    1e3 * times[times.len() / 2].as_secs_f64()
}

fn table(bench: &Bench) -> String {
    let [width, height] = bench.size;
    let mut text = format!(
        "{}: {width} x {height}, {} triangles, mean visibility cut {:.0}, {} lights; environment turned in {:.1} ms\n",
        bench.adapter, bench.triangles, bench.mean_cut, bench.lights, bench.rotation_milliseconds
    );
    for run in &bench.runs {
        let passes: Vec<String> = run.milliseconds.iter().map(|(name, ms)| format!("{name} {ms:.2} ms")).collect();
        text += &format!(
            "cut {:>4}: {}; {:.0} merged nodes and {:.0} BRDF evaluations a pixel\n",
            run.illum_cut,
            passes.join(", "),
            run.mean_merged_nodes,
            run.mean_brdf_evaluations
        );
    }
    text
}
