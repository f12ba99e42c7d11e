//! The `bake` command.

use crate::{
    args::{OutsideArgs, ShotOption, choices},
    bake_parts::{self, PartOptions},
    outputs::CommandFiles,
    terminal::{Console, ProgressReporter, ProgressStyle, option_name, write_json},
    values,
};
use anyhow::{Context, Error, Result};
use clap::{Args, ValueEnum, builder::RangedU64ValueParser};
use lapidary_core::{
    animation::{BoundAnimation, ClipTime, Playback},
    dataset::{BakeParts, BakeReport, BakeSettings, Dataset},
    ground::Ground,
    ray::RayDevices,
    scene::{Scene, pose::Poses},
};
use lapidary_interchange::{
    animation,
    formats::SceneFormat,
    image,
    import::{ImportOptions, import_with},
};
use lapidary_precompute::{BakeError, BakeJob, Preset, Shard, bake_on, bake_shard, resolve, update_file};
use lapidary_render::{
    BackendError,
    gpu::{GpuRays, Room, SharedDevice},
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Most worker threads: more use memory without benefit.
const MOST_THREADS: u64 = 1024;

/// Device that traces rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum DeviceChoice {
    /// A graphics card if there is one, else the processor
    #[default]
    Auto,
    /// The processor
    Cpu,
    /// The fastest graphics adapter, which may be an emulation
    Gpu,
}

impl DeviceChoice {
    /// The tracing adapter, if any. Shards use the CPU unless an adapter is requested: the merged file then equals a single bake
    /// bit for bit.
    fn rays(self, shard: Option<Shard>) -> Result<Option<GpuRays>, BackendError> {
        match self {
            Self::Cpu => Ok(None),
            Self::Auto => Ok(if shard.is_some() { None } else { GpuRays::of_hardware() }),
            Self::Gpu => GpuRays::on(&SharedDevice::new(Room::All)?, true).map(Some),
        }
    }
}

/// Options of `bake`.
#[derive(Args, Clone, Debug)]
pub struct BakeArgs {
    /// Scene to bake.
    #[arg(help = format!("Scene to bake: {}", SceneFormat::names()), required_unless_present = "update")]
    pub scene: Option<PathBuf>,
    /// Dataset to take over, with its settings: objects are moved to their place in --pose, or back to that in the scene file
    /// without it, and only what the move reaches is baked anew
    #[arg(
        long,
        value_name = "OLD.cuts",
        conflicts_with_all = ["scene", "variant", "of_scene", "time", "clip", "preset", "mode", "exhaustive", "ground",
            "max_vertices", "even_vertices", "no_tessellate", "shots", "device", "chunks", "shard", "resume", "OutsideArgs", "EnvironmentOptions", "SourceOptions", "MeshlessOptions",
            "ObjectBasesOptions", "WaveletOptions"]
    )]
    update: Option<PathBuf>,
    #[command(flatten)]
    outside: OutsideArgs,
    /// Variant of a glTF scene's materials (KHR_materials_variants); `lapidary info SCENE` lists them [default: the file's default
    /// materials]
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Scene of a glTF file with several, by name or by number from 0; `lapidary info FILE` lists them [default: the file's default
    /// scene]
    #[arg(long = "scene", value_name = "NAME|NUMBER")]
    of_scene: Option<String>,
    /// Objects to move from their place in the scene file: {"objects": {"NAME": {"translate": [X,Y,Z], "rotate_degrees": [X,Y,Z],
    /// "scale": S}}}, each turned about its center in the order X, Y, Z
    #[arg(long, value_name = "FILE.json")]
    pose: Option<PathBuf>,
    /// Bake the scene at this time of its animation, in seconds; a .gltf or .glb scene has one [default: at rest]
    #[arg(long, value_name = "SECONDS", value_parser = values::finite, allow_hyphen_values = true)]
    time: Option<f32>,
    /// Name of an animation of the scene [default: the first]
    #[arg(long, value_name = "NAME", requires = "time")]
    clip: Option<String>,
    /// Dataset to write
    #[arg(short, long, value_name = "FILE.cuts")]
    pub output: PathBuf,
    /// Preset to start from; the options below change its settings
    #[arg(long, default_value = "normal", value_parser = choices::preset())]
    pub preset: Preset,
    /// Parts to bake, separated by commas: environment (its visibility), indirect (surface sources, which gather one
    /// bounce of local lights), meshless (the meshless basis and its transport) and radiosity (functions of each object, for
    /// bounces that are solved anew after a move). cuts stands for environment,indirect; all stands for the first three
    #[arg(long, value_name = "PARTS", default_value_t)]
    pub mode: BakeParts,
    #[command(flatten)]
    parts: PartOptions,
    /// Trace every light and surface source from every vertex. By default, boundaries of visibility are followed, and an audit of
    /// one vertex in a hundred keeps the error within 1 % of an exhaustive bake's
    #[arg(long)]
    pub exhaustive: bool,
    /// Ground under the scene, shown in renderings by default; it takes up to a fifth more vertices [default: shadow under a single
    /// object; off if the scene has a floor, and with a meshless basis]
    #[arg(long, value_parser = choices::ground())]
    pub ground: Option<Ground>,
    /// Most vertices after tessellation, 3 or more [default: from the preset, or 1.25 times the scene's vertices if that is more]
    #[arg(long, value_name = "V")]
    pub max_vertices: Option<usize>,
    /// Spread further vertices evenly, regardless of where visibility varies: faster, for a first look
    #[arg(long)]
    pub even_vertices: bool,
    /// Do not tessellate the mesh
    #[arg(long, conflicts_with = "max_vertices")]
    pub no_tessellate: bool,
    /// Shot to bake for; may be given several times. Most vertices go where its camera looks. Give the name of a
    /// camera of the scene (16:9), or eye and target in meters, then the vertical field of view in degrees (40 if
    /// left out) and width over height (1.7778 if left out) [default: all views alike]
    #[arg(
        long = "shot",
        conflicts_with = "no_tessellate",
        value_name = "NAME|X,Y,Z:X,Y,Z[:DEG[:ASPECT]]",
        value_parser = ShotOption::parse,
        allow_hyphen_values = true
    )]
    pub shots: Vec<ShotOption>,
    /// Device that traces rays of tessellation, light tree and environment: cpu; gpu; or auto, a graphics card that can hold the scene,
    /// else cpu. Results differ only for rays along edges, and for vertices that such rays ask for; shards use cpu unless gpu is
    /// given
    #[arg(long, value_enum, default_value_t)]
    pub device: DeviceChoice,
    /// Worker threads, 1 to 1024; the result does not depend on them [default: one per core]
    #[arg(long, value_name = "T", value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_THREADS))]
    pub threads: Option<usize>,
    /// Number of checkpoints; the result does not depend on them [default: one every few seconds]
    #[arg(long, value_name = "C")]
    pub chunks: Option<usize>,
    /// Bake shard I of N, for example on several machines; `merge` then joins all shards into the dataset. Give each the same
    /// scene, options and output. An interrupted or finished shard resumes by itself
    #[arg(long, value_name = "I/N", conflicts_with = "report")]
    pub shard: Option<Shard>,
    /// Continue an interrupted bake of the same scene, options and output
    #[arg(long)]
    pub resume: bool,
    /// Write the bake report as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// How progress is shown on standard error
    #[arg(long, value_enum, default_value_t)]
    pub progress: ProgressStyle,
}

impl BakeArgs {
    fn settings(&self) -> BakeSettings {
        let mut s = self.preset.settings();
        self.parts.apply(&mut s);
        s.exhaustive = self.exhaustive;
        s.even_vertices = self.even_vertices;
        s.mode = self.mode;
        s.ground = self.ground.unwrap_or(s.ground);
        s.max_vertices = if self.no_tessellate { None } else { self.max_vertices.or(s.max_vertices) };
        s
    }

    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default()
            .reads(&self.scene)
            .reads(&self.update)
            .reads(&self.pose)
            .writes([&self.output])
            .writes(&self.report)
    }

    /// Poses with the deformations of the scene's animation at the requested time, and that time.
    fn posed_in_time(&self, poses: Poses, scene: &Scene, options: &ImportOptions) -> Result<(Poses, Option<ClipTime>)> {
        let Some(seconds) = self.time else { return Ok((poses, None)) };
        let animation = BoundAnimation::new(animation::read(self.scene_file(), options)?, scene)?;
        let index = animation.animation().clip(self.clip.as_deref())?;
        let clip = &animation.clips()[index];
        let time = ClipTime { clip: clip.name.clone(), seconds: clip.time_at(seconds, Playback::Once) };
        Ok((animation.poses_at(index, seconds, &poses)?, Some(time)))
    }

    /// Imports and bakes, with progress on standard error; Ctrl-C leaves a checkpoint.
    ///
    /// # Errors
    /// An unreadable scene, options out of range, an unwritable output, or Ctrl-C.
    pub fn run(&self, console: Console) -> Result<BakeReport> {
        let report = match &self.update {
            Some(old) => self.run_update(old, console)?,
            None => self.run_bake(console)?,
        };
        if let Some(path) = &self.report {
            write_json(path, &report)?;
        }
        Ok(report)
    }

    /// The file to bake.
    fn scene_file(&self) -> &Path {
        self.scene.as_deref().expect("the command line demands it")
    }

    fn start_threads(&self) -> Result<()> {
        let Some(threads) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        pool.context("cannot start the worker threads; choose a smaller --threads")
    }

    /// Takes over a dataset and bakes anew what the poses reach.
    fn run_update(&self, old: &Path, console: Console) -> Result<BakeReport> {
        self.start_threads()?;
        let progress = ProgressReporter::new(self.progress, console);
        progress.cancel_on_interrupt();
        let dataset = Dataset::read(old, image::decode)?;
        let poses = self.pose.as_deref().map(|path| Poses::read(path, &dataset.scene)).transpose()?;
        let mut scene = dataset.scene.clone();
        scene.place_again(&poses.unwrap_or_default()).map_err(BakeError::Pose)?;
        let updated = update_file(&dataset, scene, &self.output, &progress)?;
        progress.finish();
        Ok(updated.report)
    }

    fn run_bake(&self, console: Console) -> Result<BakeReport> {
        let rays = self.device.rays(self.shard)?;
        let devices = rays.as_ref().map(|rays| rays as &dyn RayDevices);
        let mut settings = resolve(self.settings())?;
        self.start_threads()?;
        let progress = ProgressReporter::new(self.progress, console);
        progress.cancel_on_interrupt();
        let start = Instant::now();
        let options =
            ImportOptions { variant: self.variant.clone(), scene: self.of_scene.clone(), ..self.outside.into() };
        let imported = import_with(self.scene_file(), &options)?;
        imported.report.warnings.iter().for_each(|w| progress.warn(w));
        // The scene's own buffers and pictures are only known now.
        self.files().reads(&imported.report.files).check()?;
        let vertices = imported.scene.mesh.positions.len();
        if self.max_vertices.is_none() {
            settings = settings.with_room_for(vertices);
        }
        if self.ground.is_none() {
            let suits = settings.mode.parts().all(|part| bake_parts::of(part).suits_a_ground());
            let ground = if suits { Ground::suiting(&imported.scene.mesh) } else { Ground::Off };
            settings = settings.with_ground(ground);
        }
        let poses = self.pose.as_deref().map(|path| Poses::read(path, &imported.scene)).transpose()?;
        let (poses, clip_time) = self.posed_in_time(poses.unwrap_or_default(), &imported.scene, &options)?;
        let shots = self.shots.iter().map(|shot| shot.of(&imported.scene)).collect::<Result<_>>()?;
        let settings = settings.for_shots(shots)?;
        let job = BakeJob {
            settings,
            poses,
            clip_time,
            output: self.output.clone(),
            inputs: imported.report.files,
            chunks: self.chunks,
            resume: self.resume,
            import_secs: start.elapsed().as_secs_f64(),
            warnings: imported.report.warnings,
        };
        let baked = match self.shard {
            Some(shard) => bake_shard(imported.scene, &job, shard, devices, &progress),
            None => bake_on(imported.scene, &job, devices, &progress).map(|dataset| dataset.report),
        };
        let report = baked.map_err(|error| of_scene(error, self.scene_file()))?;
        progress.finish();
        Ok(report)
    }
}

/// Adds the scene's path to errors in the scene. Other errors name their file or concern none.
fn of_scene(error: BakeError, scene: &Path) -> Error {
    match error {
        BakeError::Points(_) | BakeError::Basis(_) | BakeError::Memory { .. } | BakeError::TooManyTexels { .. } => {
            Error::msg(format!("{} ({})", error.text(option_name), scene.display()))
        }
        other => other.into(),
    }
}
