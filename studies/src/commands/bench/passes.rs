//! `lapidary bench FILE.cuts`: times of each pass of a frame.

use super::{JsonArgs, drag, edits, median, resolve};
use crate::{
    args::{DeviceArgs, ViewedScene},
    ladder::Cuts,
};
use anyhow::Result;
use clap::Args;
use lapidary_core::lights::Light;
use lapidary_render::{
    Backend, BackendError, Changes, CpuBackend, LightRig, LitScene, LocalRig, Look, Post, Situation,
    gpu::{GpuBackend, PassTimes},
};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

/// Options of the figures by pass.
#[derive(Args, Clone, Debug)]
pub struct PassesArgs {
    /// Merge the stored cuts with illumination cuts of these sizes, separated by commas, instead of lit cuts
    #[arg(long, value_name = "K,..", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cuts: Vec<u32>,
    /// Frames in the median, after one to warm up
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) frames: u32,
    /// Drag this object by half its width in this many frames after the one that picks it up, and measure picture times meanwhile
    #[arg(long, value_name = "OBJECT", conflicts_with = "illum_cuts")]
    drag: Option<String>,
    /// Edit this material, orbit and rotate the environment, in this many frames each, and measure picture times
    #[arg(long, value_name = "MATERIAL", conflicts_with_all = ["illum_cuts", "drag"])]
    edits: Option<String>,
    /// Move this object by half its width, there and back, and measure how soon the bounced light is solved anew; for a dataset baked
    /// with radiosity
    #[arg(long, value_name = "OBJECT", conflicts_with_all = ["illum_cuts", "drag", "edits", "DeviceArgs"])]
    resolve: Option<String>,
    #[command(flatten)]
    pub(super) device: DeviceArgs,
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
    /// Mean cut over surface sources; 0 without.
    mean_source_cut: f64,
    lights: usize,
    sources: usize,
    frames: u32,
    /// Time from a rotated environment to a new illumination cut of 256: leaf radiance, tree and cut, on one thread.
    rotation_milliseconds: f64,
    /// Time from a moved local light to its complete bounced light, with an illumination cut of 256; absent without a light or
    /// bounced light.
    light_moved_milliseconds: Option<f64>,
    runs: Vec<Run>,
}

/// Figures of a picture's frames.
#[derive(Debug, Serialize)]
struct Run {
    #[serde(flatten)]
    cuts: Cuts,
    /// Median times by pass, and `total`.
    milliseconds: BTreeMap<&'static str, f64>,
    mean_merged_nodes: f64,
    mean_brdf_evaluations: f64,
}

/// Measures and prints.
///
/// # Errors
/// Bounced light that the dataset lacks, or no adapter if one is required.
pub fn run(args: &PassesArgs, viewed: &ViewedScene, json: &JsonArgs) -> Result<()> {
    if let Some(object) = &args.drag {
        return drag::run(viewed, object, args.frames, args.device, json);
    }
    if let Some(material) = &args.edits {
        return edits::run(viewed, material, args.frames, args.device, json);
    }
    if let Some(object) = &args.resolve {
        return resolve::run(viewed, object, args.frames, json);
    }
    let measurement = Measurement::new(args, viewed)?;
    let gpu = args.device.gpu()?;
    let adapter = gpu.as_ref().map_or("cpu".to_owned(), Backend::name);
    let runs = match gpu {
        Some(gpu) => measurement.gpu_runs(gpu)?,
        None => measurement.cpu_runs()?,
    };
    let report = &viewed.baked.dataset.report;
    let indirect = report.indirect.as_ref();
    let bench = Bench {
        adapter,
        size: viewed.view.size,
        vertices: viewed.baked.dataset.scene.mesh.positions.len(),
        triangles: viewed.baked.dataset.scene.mesh.triangles.len(),
        mean_cut: report.mean_cut,
        mean_source_cut: indirect.map_or(0.0, |r| r.mean_cut),
        lights: viewed.baked.dataset.tree.len(),
        sources: indirect.map_or(0, |r| r.sources),
        frames: args.frames,
        rotation_milliseconds: rotation(viewed, args.frames),
        light_moved_milliseconds: measurement.light_moved(),
        runs,
    };
    json.tell(&bench, || table(&bench))
}

/// The measured picture and the number of frames.
struct Measurement<'a> {
    args: &'a PassesArgs,
    viewed: &'a ViewedScene,
    look: Look,
}

impl<'a> Measurement<'a> {
    fn new(args: &'a PassesArgs, viewed: &'a ViewedScene) -> Result<Self> {
        Ok(Self { args, viewed, look: viewed.look()? })
    }

    fn gpu_runs(&self, gpu: GpuBackend) -> Result<Vec<Run>> {
        self.runs(gpu, |scene| Ok(passes(scene.backend().timed_sample(0, &Post::default())?)))
    }

    fn cpu_runs(&self) -> Result<Vec<Run>> {
        let height = self.look.view.size[1];
        self.runs(CpuBackend::new(), |scene| {
            let start = Instant::now();
            scene.render_rows(0, 0..height)?;
            Ok(BTreeMap::from([("total", start.elapsed())]))
        })
    }

    /// One run per illumination cut, or one with lit cuts; `frame` renders and returns the time of each pass.
    fn runs<B: Backend>(
        &self,
        backend: B,
        frame: impl Fn(&mut LitScene<B>) -> Result<Times, BackendError>,
    ) -> Result<Vec<Run>> {
        let mut scene = LitScene::new(Box::new(backend), self.viewed.baked.clone())?;
        let run = |cuts: Cuts| {
            let look = cuts.shown(&self.look);
            let times = frames_of(&mut scene, &look, self.args.frames, &frame)?;
            scene.begin(&look.view, look.sampling)?;
            scene.render_rows(0, 0..look.view.size[1])?;
            let stats = scene.backend().stats()?;
            Ok(Run {
                cuts,
                milliseconds: medians(&times),
                mean_merged_nodes: stats.mean_merged_nodes,
                mean_brdf_evaluations: stats.mean_brdf_evaluations,
            })
        };
        let stored: Vec<Cuts> = self.args.illum_cuts.iter().map(|&size| Cuts::Refine(size)).collect();
        let cuts = if stored.is_empty() { vec![Cuts::Lit(self.look.tau)] } else { stored };
        cuts.into_iter().map(run).collect()
    }

    /// Median milliseconds from a moved light to its bounces.
    fn light_moved(&self) -> Option<f64> {
        let Look { components, solution, lights, .. } = &self.look;
        let bounces = components.indirect && self.viewed.baked.dataset.has_bounces();
        if !bounces || lights.is_empty() {
            return None;
        }
        let mut rig = LocalRig::new(&self.viewed.baked);
        let mut situation = Situation::unlit(&self.viewed.baked);
        situation.gathering.illum_cut = 256;
        let mut redo = |lights: &[Light]| {
            situation.lights = lights.into();
            rig.note(Changes { lights: true, ..Changes::NONE });
            let start = Instant::now();
            while rig.advance(&situation, *solution) {}
            start.elapsed()
        };
        redo(lights);
        let mut lights = lights.to_vec();
        let times = (0..self.args.frames).map(|_| {
            lights[0].position.x += 1e-3;
            redo(&lights)
        });
        Some(median(times.collect()))
    }
}

/// Times of frames of a look, after one to warm up.
pub(super) fn frames_of<B: Backend>(
    scene: &mut LitScene<B>,
    look: &Look,
    frames: u32,
    frame: impl Fn(&mut LitScene<B>) -> Result<Times, BackendError>,
) -> Result<Vec<Times>, BackendError> {
    scene.light(look)?;
    let mut anew = || {
        scene.begin(&look.view, look.sampling)?;
        frame(scene)
    };
    anew()?;
    (0..frames).map(|_| anew()).collect()
}

/// Time of each pass of a frame.
pub(super) type Times = BTreeMap<&'static str, Duration>;

pub(super) fn passes(t: PassTimes) -> Times {
    BTreeMap::from([
        ("visibility", t.visibility),
        ("deferred", t.deferred),
        ("merge", t.merge),
        ("display", t.display),
        ("total", t.visibility + t.deferred + t.merge + t.display),
    ])
}

pub(super) fn medians(times: &[Times]) -> BTreeMap<&'static str, f64> {
    let of = |pass: &'static str| median(times.iter().map(|t| t[pass]).collect());
    times[0].keys().map(|&pass| (pass, of(pass))).collect()
}

/// Median milliseconds from a rotated environment to nodes and illumination cut.
fn rotation(viewed: &ViewedScene, frames: u32) -> f64 {
    let mut rig = LightRig::new(&viewed.baked.dataset.tree);
    let mut light = viewed.light.clone();
    rig.lighting(&light, 256);
    let times = (0..frames).map(|_| {
        light.rotation += 0.01;
        let start = Instant::now();
        rig.lighting(&light, 256);
        start.elapsed()
    });
    median(times.collect())
}

fn table(bench: &Bench) -> String {
    let [width, height] = bench.size;
    let mut text = format!(
        "{}: {width} x {height}, {} triangles, mean visibility cut {:.0}, {} lights; environment turned in {:.1} ms\n",
        bench.adapter, bench.triangles, bench.mean_cut, bench.lights, bench.rotation_milliseconds
    );
    let sources = || format!("{} sources, mean cut {:.0}", bench.sources, bench.mean_source_cut);
    let moved = bench.light_moved_milliseconds.map(|ms| format!("light moved in {ms:.1} ms"));
    let bounces: Vec<String> = (bench.sources > 0).then(sources).into_iter().chain(moved).collect();
    if !bounces.is_empty() {
        text += &(bounces.join("; ") + "\n");
    }
    for run in &bench.runs {
        let passes: Vec<String> = run.milliseconds.iter().map(|(name, ms)| format!("{name} {ms:.2} ms")).collect();
        text += &format!(
            "{:>10}: {}; {:.0} merged nodes and {:.0} BRDF evaluations per pixel\n",
            run.cuts.label(),
            passes.join(", "),
            run.mean_merged_nodes,
            run.mean_brdf_evaluations
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_light_is_told_with_sources_and_without() {
        let lines = |sources: usize, light_moved_milliseconds: Option<f64>| {
            let bench = Bench {
                adapter: "cpu".into(),
                size: [4, 3],
                vertices: 3,
                triangles: 1,
                mean_cut: 1.0,
                mean_source_cut: 20.0,
                lights: 8,
                sources,
                frames: 1,
                rotation_milliseconds: 0.5,
                light_moved_milliseconds,
                runs: Vec::new(),
            };
            table(&bench).lines().skip(1).collect::<Vec<_>>().join("|")
        };
        assert_eq!(lines(64, Some(7.3)), "64 sources, mean cut 20; light moved in 7.3 ms");
        assert_eq!(lines(64, None), "64 sources, mean cut 20");
        assert_eq!(lines(0, Some(7.3)), "light moved in 7.3 ms", "the meshless solution alone");
        assert_eq!(lines(0, None), "");
    }
}
