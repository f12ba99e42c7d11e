//! `lapidary bench --gpu-suite`: what a graphics adapter takes for the bundled scenes, by fragments and by kernels, with the
//! difference from the CPU's pictures.

mod report;

use super::{
    JsonArgs, PASSES, PICTURE,
    against::program::{Patience, Program},
    drag::{Detailed, dragged, object_named},
    passes::{Times, frames_of, medians, passes},
};
use crate::{
    args::{LocalLightArgs, ViewArgs, ViewedScene, shader_source},
    bundled::DataFolder,
    ladder::Cuts,
    terminal::{Console, Steps},
};
use anyhow::{Context, Result, anyhow};
use clap::{Args, Parser};
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_interchange::image;
use lapidary_precompute::Observer;
use lapidary_render::{
    Backend, BackendError, CpuBackend, ImplicitDetail, LitScene, Look, Post, View,
    compare::compare,
    gpu::{GpuBackend, GpuPath, Room, SharedDevice, faster_path},
};
use report::{Bake, Compiled, Difference, Drag, Picture, Suite};
use std::{
    ffi::OsString,
    path::PathBuf,
    time::{Duration, Instant},
};
use tempfile::TempDir;

/// Options of the suite.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Suite of a graphics adapter on the bundled scenes")]
pub struct SuiteArgs {
    /// Measure the graphics adapter on the bundled scenes, by fragment and by compute shaders: times by pass, differences from the
    /// CPU's pictures, bakes, drags, compile times and memory
    #[arg(
        long,
        conflicts_with_all = PICTURE,
        conflicts_with_all = PASSES,
        conflicts_with_all = ["file", "surfels", "against"]
    )]
    pub gpu_suite: bool,
}

/// A scene, and what is baked of it.
struct Scene {
    name: &'static str,
    mode: &'static str,
}

const STILL_LIFE: Scene = Scene { name: "still-life", mode: "environment" };
const INTERIOR: Scene = Scene { name: "interior", mode: "all" };
const COLOR_BOX: Scene = Scene { name: "color-box", mode: "all" };

/// A picture.
struct Row {
    scene: &'static Scene,
    name: &'static str,
    /// Options of the view; `{maps}` is replaced by the folder of environments.
    options: &'static str,
    /// Nodes of an illumination cut in place of lit cuts.
    illum_cut: Option<u32>,
}

const fn row(scene: &'static Scene, name: &'static str, options: &'static str) -> Row {
    Row { scene, name, options, illum_cut: None }
}

const STUDIO: &str = "--env {maps}/studio.hdr --components environment";
const DAY: &str = "--env {maps}/sun-and-sky.hdr --components environment";
const LAMPS: &str = "--env none --components direct,indirect --solution cuts";
const ALL: &str = "--env {maps}/sun-and-sky.hdr --components environment,direct,indirect --solution cuts";
const MESHLESS: &str = "--env none --components direct,indirect --solution meshless";
const GLOSS: &str = "--env none --components direct,indirect --solution cuts+gloss";

const ROWS: [Row; 7] = [
    row(&STILL_LIFE, "studio", STUDIO),
    Row { illum_cut: Some(256), ..row(&STILL_LIFE, "studio, illumination cut 256", STUDIO) },
    row(&STILL_LIFE, "sun and sky", DAY),
    row(&INTERIOR, "one bounce by cuts", LAMPS),
    row(&INTERIOR, "sun, sky and bounce", ALL),
    row(&INTERIOR, "meshless", MESHLESS),
    row(&COLOR_BOX, "gloss", GLOSS),
];

/// Scenes with the object that is dragged in a row's light.
const DRAGS: [(usize, &str); 2] = [(3, "Box lid"), (6, "Short block")];
const DRAG_STEPS: u32 = 4;

/// Frames in a median, after one to warm up.
const FRAMES: u32 = 5;
/// Times are of this size, and those of an emulated adapter of the other, which is that of the differences.
const SIZE: [u32; 2] = [1920, 1080];
const SMALL: [u32; 2] = [320, 180];
const BAKE_LIMIT: Duration = Duration::from_secs(300);

const PATHS: [GpuPath; 2] = [GpuPath::Fragment, GpuPath::Compute];

/// Options of a row, as `bench` reads them.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    local: LocalLightArgs,
}

/// The bundled data, and where their bakes are.
struct Bench<'a> {
    data: &'a DataFolder,
    folder: TempDir,
    console: Console,
    device: &'a SharedDevice,
    steps: Steps,
}

/// Measures and prints.
///
/// # Errors
/// No adapter, a lost one, missing bundled data, an unwritable report, or Ctrl-C.
pub fn run(data: &DataFolder, json: &JsonArgs, console: Console) -> Result<()> {
    let start = Instant::now();
    let device = SharedDevice::new(Room::All)?;
    let size = if device.is_emulated() { SMALL } else { SIZE };
    let folder = tempfile::tempdir().context("cannot bake to the folder for temporary files; check its free space")?;
    let bench = Bench { data, folder, console, device: &device, steps: Steps::new(console) };
    let bakes = [STILL_LIFE, INTERIOR, COLOR_BOX].iter().map(|scene| bench.bakes(scene)).collect::<Result<Vec<_>>>()?;
    let (mut pictures, mut compiled) = (Vec::new(), Vec::new());
    for row in &ROWS {
        pictures.extend(bench.pictures(row, size, &mut compiled)?);
    }
    let drags = DRAGS.iter().map(|&(row, object)| bench.drag(&ROWS[row], object)).collect::<Result<Vec<_>>>()?;
    let suite = Suite {
        adapter: device.facts(),
        faster_path: faster_path(&device)?,
        size,
        bakes: bakes.into_iter().flatten().collect(),
        pictures,
        drags,
        compiled,
        seconds: start.elapsed().as_secs_f64(),
    };
    json.tell(&suite, || suite.table())
}

impl Bench<'_> {
    /// Bakes a scene by the processor, and by an adapter that is more than an emulation; the pictures take the first.
    fn bakes(&self, scene: &Scene) -> Result<Vec<Bake>> {
        let this = Program::open(&std::env::current_exe().context("cannot find this program's own file")?)?;
        let bake = |device: &'static str| -> Result<Bake> {
            self.steps.begin(&format!("{}: bake, {device}", scene.name));
            let output = self.baked(scene).with_extension(if device == "cpu" { "cuts" } else { "gpu.cuts" });
            let words = ["bake", "--preset", "draft", "--quiet", "--mode", scene.mode, "--device", device, "-o"];
            let words: Vec<OsString> = words.map(OsString::from).into_iter().collect();
            let words = [words, vec![output.clone().into(), self.data.scene(scene.name).into()]].concat();
            let patience = Patience { limit: BAKE_LIMIT, stops: &|| self.steps.reporter.cancelled() };
            let finished = this.run(&words, patience).map_err(|error| anyhow!("the bake of {} {error}", scene.name))?;
            let report = Dataset::read(&output, image::decode)?.report;
            Ok(Bake { scene: scene.name, device, seconds: finished.time.as_secs_f64(), rays: report.rays_traced })
        };
        let devices = if self.device.is_emulated() { &["cpu"][..] } else { &["cpu", "gpu"] };
        devices.iter().map(|device| bake(device)).collect()
    }

    fn baked(&self, scene: &Scene) -> PathBuf {
        self.folder.path().join(scene.name).with_extension("cuts")
    }

    /// A row's picture by each path, and in `compiled` what its passes took to compile.
    fn pictures(&self, row: &Row, size: [u32; 2], compiled: &mut Vec<Compiled>) -> Result<Vec<Picture>> {
        self.steps.begin(&row.label());
        let viewed = self.viewed(row)?;
        let cuts = row.illum_cut.map_or(Cuts::Lit(viewed.look()?.tau), Cuts::Refine);
        let look = cuts.shown(&viewed.look()?);
        let small = Look { view: View { size: SMALL, ..look.view.clone() }, ..look.clone() };
        let large = Look { view: View { size, ..look.view.clone() }, ..look };
        let expected = shown(&mut LitScene::new(Box::new(CpuBackend::new()), viewed.baked.clone())?, &small)?;
        let mut scene = LitScene::new(Box::new(self.backend()?), viewed.baked.clone())?;
        let mut picture = |path: GpuPath| {
            self.steps.check()?;
            scene.backend().set_path(path)?;
            let times = frames_of(&mut scene, &large, FRAMES, timed)?;
            let metrics = compare(&shown(&mut scene, &small)?, &expected)?;
            compiled.push(Compiled::new(row.label(), path, &scene.backend().compile_times()));
            let allocated_bytes = self.device.allocated_bytes();
            let difference = Difference { relative: metrics.rel_rmse, flip: metrics.flip };
            Ok(Picture { name: row.label(), path, milliseconds: medians(&times), difference, allocated_bytes })
        };
        PATHS.into_iter().map(&mut picture).collect()
    }

    fn drag(&self, row: &Row, object: &str) -> Result<Drag> {
        self.steps.begin(&format!("{}, dragged {object}", row.label()));
        let viewed = self.viewed(row)?;
        let index = object_named(&viewed.baked.dataset.scene, object)?;
        let backend: Box<dyn Backend> = Box::new(self.backend()?);
        let mut scene = LitScene::new(backend, viewed.baked.clone())?;
        let looks = dragged(&viewed.baked.dataset.scene, index, &viewed.look()?, DRAG_STEPS);
        let ends = [ImplicitDetail::LADDER.first(), ImplicitDetail::LADDER.last()].into_iter().flatten();
        let details = ends.map(|&detail| Detailed::measure(&mut scene, detail, &looks)).collect::<Result<_, _>>()?;
        Ok(Drag { name: row.label(), object: object.into(), details })
    }

    /// By fragments, until another path is set.
    fn backend(&self) -> Result<GpuBackend, BackendError> {
        GpuBackend::new(self.device.clone(), &shader_source(), GpuPath::Fragment)
    }

    fn viewed(&self, row: &Row) -> Result<ViewedScene> {
        let maps = self.data.environment_folder();
        let options = row.options.split_whitespace().map(|word| word.replace("{maps}", &maps.display().to_string()));
        let words = ["bench".into(), self.baked(row.scene).into_os_string()].into_iter();
        let Options { view, local } = Options::try_parse_from(words.chain(options.map(OsString::from)))?;
        view.resolve(&local, self.console)
    }
}

impl Row {
    fn label(&self) -> String {
        format!("{}: {}", self.scene.name, self.name)
    }
}

fn timed(scene: &mut LitScene<GpuBackend>) -> Result<Times, BackendError> {
    Ok(passes(scene.backend().timed_sample(0, &Post::default())?))
}

fn shown<B: Backend>(scene: &mut LitScene<B>, look: &Look) -> Result<Image> {
    Ok(scene.show_whole(look)?.image)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_every_row_are_read() {
        for row in &ROWS {
            let words = ["bench", "a.cuts"].into_iter().chain(row.options.split_whitespace());
            assert!(Options::try_parse_from(words).is_ok(), "{}", row.label());
        }
        assert!(Options::try_parse_from(["bench", "a.cuts", "--solution", "guess"]).is_err(), "negative control");
    }
}
