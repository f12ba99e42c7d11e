//! `lapidary bench FILE.cuts --surfels N,..`: times of implicit visibility on the cores and on an adapter.

use super::{
    JsonArgs,
    passes::{PassesArgs, Times, medians},
};
use anyhow::Result;
use glam::{Vec3, Vec3A};
use lapidary_core::{
    dataset::Dataset,
    implicit::{BinLayout, Bins, LeafLight, Lighting, Views, forest::SurfelForest},
};
use lapidary_render::{
    Backend, BackendError,
    gpu::{GpuBackend, GpuForest, GpuImplicit},
};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

/// Bounces to follow.
const BOUNCES: u32 = 2;

/// All figures.
#[derive(Debug, Serialize)]
struct Bench {
    frames: u32,
    bounces: u32,
    runs: Vec<Run>,
}

/// Figures for one number of surfels.
#[derive(Debug, Serialize)]
struct Run {
    /// `cpu`, or the name of the adapter.
    adapter: String,
    surfels: usize,
    /// Median times by step, and `total`, which on an adapter includes transfers.
    milliseconds: BTreeMap<&'static str, f64>,
}

/// Measures and prints.
///
/// # Errors
/// No adapter if one is required, or a failing one.
pub fn run(surfels: &[u32], args: &PassesArgs, dataset: &Dataset, json: &JsonArgs) -> Result<()> {
    let on_adapter = |gpu: GpuBackend| Ok::<_, BackendError>((gpu.name(), GpuImplicit::on(gpu.device())?));
    let gpu = args.device.gpu()?.map(on_adapter).transpose()?;
    let mut runs = Vec::new();
    for &surfels in surfels {
        let posed = Posed::new(dataset, surfels);
        runs.push(posed.run("cpu".into(), &posed.by_cores(args.frames)));
        if let Some((name, adapter)) = &gpu {
            runs.push(posed.run(name.clone(), &posed.on_adapter(adapter, args.frames)?));
        }
    }
    let bench = Bench { frames: args.frames, bounces: BOUNCES, runs };
    json.tell(&bench, || table(&bench))
}

/// A scene as baked; each frame recomputes everything.
struct Posed<'a> {
    positions: &'a [Vec3],
    forest: SurfelForest,
    gray: Vec<Vec3>,
}

impl<'a> Posed<'a> {
    fn new(dataset: &'a Dataset, surfels: u32) -> Self {
        let mesh = &dataset.scene.mesh;
        let forest = SurfelForest::new(mesh, &dataset.two_sided, surfels);
        Self { positions: &mesh.positions, gray: vec![Vec3::splat(0.5); forest.riders().len()], forest }
    }

    fn run(&self, adapter: String, times: &[Times]) -> Run {
        Run { adapter, surfels: self.gray.len(), milliseconds: medians(times) }
    }

    fn lighting(&self) -> Lighting<'_> {
        Lighting { reflectance: &self.gray, emitted: &self.gray, received: &self.gray, sky: &|_| Vec3::ONE }
    }

    /// Times of frames after one to warm up.
    fn by_cores(&self, frames: u32) -> Vec<Times> {
        let mut forest = self.forest.clone();
        (0..=frames).map(|_| self.frame_by_cores(&mut forest)).skip(1).collect()
    }

    fn frame_by_cores(&self, forest: &mut SurfelForest) -> Times {
        let (update, ()) = timed(|| forest.update(self.positions, &|_| true));
        let discs = forest.discs();
        let (walk, views): (_, Views) = timed(|| Bins::walk(discs, BinLayout::FINEST, &|_| true).views());
        let (light, _) = timed(|| LeafLight::new(discs, &views, &self.lighting(), BOUNCES));
        // Once for emission, and once per bounce.
        let sent = vec![Vec3A::ONE; self.gray.len()];
        let pull = timed(|| discs.pull(&sent)).0 * (1 + BOUNCES);
        steps([update, walk, pull, light.saturating_sub(pull)], update + walk + light)
    }

    fn on_adapter(&self, adapter: &GpuImplicit, frames: u32) -> Result<Vec<Times>, BackendError> {
        let mut forest = adapter.forest(&self.forest, self.positions.len(), BinLayout::FINEST)?;
        (0..=frames).map(|_| self.frame_on_adapter(&mut forest)).skip(1).collect()
    }

    fn frame_on_adapter(&self, forest: &mut GpuForest) -> Result<Times, BackendError> {
        let start = Instant::now();
        forest.update(self.positions)?;
        forest.walk()?;
        forest.light(&self.lighting(), BOUNCES)?;
        let times = forest.times();
        Ok(steps([times.update, times.walk, times.pull, times.bounce], start.elapsed()))
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed(), result)
}

fn steps([update, walk, pull, bounce]: [Duration; 4], total: Duration) -> Times {
    BTreeMap::from([("update", update), ("walk", walk), ("pull", pull), ("bounce", bounce), ("total", total)])
}

fn table(bench: &Bench) -> String {
    let mut text = format!("implicit visibility, {} bounces, medians of {} frames\n", bench.bounces, bench.frames);
    for run in &bench.runs {
        let steps = ["update", "walk", "pull", "bounce", "total"]
            .map(|step| format!("{step} {:.2} ms", run.milliseconds[step]));
        text += &format!("{:>6} surfels, {}: {}\n", run.surfels, run.adapter, steps.join(", "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes::dataset;

    #[test]
    fn each_step_of_each_number_of_surfels_has_its_time() {
        let dataset = dataset(&["a"], &[]);
        let runs = [64, 256].map(|surfels| {
            let posed = Posed::new(&dataset, surfels);
            posed.run("cpu".into(), &posed.by_cores(1))
        });
        for (run, surfels) in runs.iter().zip([64, 256]) {
            let parts = ["update", "walk", "pull", "bounce"].map(|step| run.milliseconds[step]);
            assert!(run.surfels == surfels && parts.iter().sum::<f64>() <= 1.2 * run.milliseconds["total"] + 1.0);
            assert!(run.milliseconds["walk"] > 0.0);
        }
        let lines = table(&Bench { frames: 1, bounces: BOUNCES, runs: runs.into() });
        assert!(lines.lines().count() == 3 && lines.contains("   256 surfels, cpu: update"));
    }
}
