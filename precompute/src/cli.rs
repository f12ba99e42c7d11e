//! The `bake`, `info` and `verify` commands, shared by the binaries `lapidary` and `precompute`.

mod progress;

pub use progress::{ProgressReporter, ProgressStyle, phase_bar};

use crate::{BakeJob, Preset, Verification, bake};
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeMode, BakeReport, BakeSettings, Dataset, IndirectReport, MeshlessReport},
    import::import,
    light_tree::TreeKind,
};
use std::{io::Write, path::PathBuf, time::Instant};

/// Clustering metric of the light tree, as an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TreeOption {
    /// Direction alone (Eq. 10 of the paper).
    Geometric,
    /// Pilot visibility alone (Eq. 11).
    DataDriven,
    /// Both, weighted by --beta (Eq. 12).
    Mixed,
}

impl From<TreeOption> for TreeKind {
    fn from(option: TreeOption) -> Self {
        match option {
            TreeOption::Geometric => Self::Geometric,
            TreeOption::DataDriven => Self::DataDriven,
            TreeOption::Mixed => Self::Mixed,
        }
    }
}

/// Preset, as an option.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PresetOption {
    /// 8,192 lights and surface sources, up to 30,000 vertices: seconds.
    Draft,
    /// 32,768 lights, sigma 2, up to 100,000 vertices.
    #[default]
    Normal,
    /// 32,768 lights, sigma 1.5, up to 300,000 vertices.
    High,
}

impl From<PresetOption> for Preset {
    fn from(option: PresetOption) -> Self {
        match option {
            PresetOption::Draft => Self::Draft,
            PresetOption::Normal => Self::Normal,
            PresetOption::High => Self::High,
        }
    }
}

/// What is baked, as an option.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ModeOption {
    /// Visibility of the environment.
    #[default]
    Environment,
    /// Surface sources, which gather a bounce of local lights.
    Indirect,
    /// Both, and what the sources see of the environment.
    Cuts,
    /// The meshless basis and its transport.
    Meshless,
    /// All of these.
    All,
}

impl From<ModeOption> for BakeMode {
    fn from(option: ModeOption) -> Self {
        match option {
            ModeOption::Environment => Self::Environment,
            ModeOption::Indirect => Self::Indirect,
            ModeOption::Cuts => Self::Cuts,
            ModeOption::Meshless => Self::Meshless,
            ModeOption::All => Self::All,
        }
    }
}

/// Options of `bake`.
#[derive(Args, Clone, Debug)]
pub struct BakeArgs {
    /// Scene to bake: .obj, .gltf, .glb or .ply
    pub scene: PathBuf,
    /// Dataset to write
    #[arg(short, long, value_name = "FILE.cuts")]
    pub output: PathBuf,
    /// Starting point for the options below
    #[arg(long, value_enum, default_value_t)]
    pub preset: PresetOption,
    /// What to bake
    #[arg(long, value_enum, default_value_t)]
    pub mode: ModeOption,
    /// Number of surface sources: a power of two up to 32768 [default: that of the preset]
    #[arg(long, value_name = "N")]
    pub sources: Option<usize>,
    /// Error bound of a cluster of sources: split while |C| var > sigma², in units of a source's part of the
    /// hemisphere; 0 to 1000, smaller is finer [default: 4]
    #[arg(long, value_name = "S")]
    pub source_sigma: Option<f32>,
    /// A place in the open from which light reaches all that matters, in metres; surfaces that it cannot
    /// reach get no sources [default: that of a camera, or one that is searched for]
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    pub viewpoint: Option<Vec3>,
    /// Levels of the meshless basis, 1 to 8 [default: 6]
    #[arg(long, value_name = "L")]
    pub levels: Option<usize>,
    /// How many of its first levels send light [default: 4]
    #[arg(long, value_name = "L")]
    pub sender_levels: Option<usize>,
    /// Distance of its coarsest points in metres [default: one that gives about 300 of them]
    #[arg(long, value_name = "R")]
    pub coarse_radius: Option<f32>,
    /// Rays by which each of its points gathers light, 16 to 65536 [default: 512]
    #[arg(long, value_name = "N")]
    pub gather_rays: Option<usize>,
    /// Links between its functions are kept above this share of the light of a half grey sender, 0 to 1; smaller
    /// is finer [default: 0.025]
    #[arg(long, value_name = "E")]
    pub epsilon: Option<f32>,
    /// Number of light samples: a power of two up to 32768 [default: that of the preset]
    #[arg(long, value_name = "N")]
    pub lights: Option<usize>,
    /// Metric that the light tree is clustered by [default: mixed]
    #[arg(long, value_enum)]
    pub tree: Option<TreeOption>,
    /// Weight of the geometric metric in a mixed tree, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "B")]
    pub beta: Option<f32>,
    /// Error bound of a cluster: split while |C| var > sigma² (Eq. 5); 0 to 1000, usually 1.5 to 3, smaller
    /// is finer [default: that of the preset]
    #[arg(long, value_name = "S")]
    pub sigma: Option<f32>,
    /// Most nodes of a vertex's cut, 1 or more [default: no limit]
    #[arg(long, value_name = "K")]
    pub max_cut: Option<u32>,
    /// Bound the error of each whole cut instead of each cluster, 0 to 1000 [default: off]
    #[arg(long, value_name = "E")]
    pub total_error: Option<f32>,
    /// Most bytes for all cuts together, 1024 or more; they are coarsened until they fit [default: no limit]
    #[arg(long, value_name = "BYTES")]
    pub max_bytes: Option<u64>,
    /// Vertex clusters of the pilot visibility, 1 to 65536 [default: that of the preset]
    #[arg(long, value_name = "M")]
    pub pilot_clusters: Option<usize>,
    /// Most vertices after tessellation, 3 or more [default: that of the preset]
    #[arg(long, value_name = "V")]
    pub max_vertices: Option<usize>,
    /// Leave the mesh as it is
    #[arg(long, conflicts_with = "max_vertices")]
    pub no_tessellate: bool,
    /// Worker threads; the result does not depend on them [default: one for each core]
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
    /// Number of checkpoints; the result does not depend on them [default: one every few seconds]
    #[arg(long, value_name = "C")]
    pub chunks: Option<usize>,
    /// Go on with an interrupted bake of the same scene, options and output
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
        let mut s = Preset::from(self.preset).settings();
        s.lights = self.lights.unwrap_or(s.lights);
        s.tree = self.tree.map_or(s.tree, Into::into);
        s.beta = self.beta.unwrap_or(s.beta);
        s.criterion.sigma = self.sigma.unwrap_or(s.criterion.sigma);
        s.criterion.max_nodes = self.max_cut.unwrap_or(s.criterion.max_nodes);
        s.criterion.total_error = self.total_error.or(s.criterion.total_error);
        s.max_bytes = self.max_bytes.or(s.max_bytes);
        s.pilot_clusters = self.pilot_clusters.unwrap_or(s.pilot_clusters);
        s.mode = self.mode.into();
        s.indirect.sources = self.sources.unwrap_or(s.indirect.sources);
        s.indirect.criterion.sigma = self.source_sigma.unwrap_or(s.indirect.criterion.sigma);
        s.indirect.viewpoint = self.viewpoint.or(s.indirect.viewpoint);
        s.meshless.levels = self.levels.unwrap_or(s.meshless.levels);
        s.meshless.sender_levels = self.sender_levels.unwrap_or(s.meshless.sender_levels.min(s.meshless.levels));
        s.meshless.coarse_radius = self.coarse_radius.or(s.meshless.coarse_radius);
        s.meshless.rays = self.gather_rays.unwrap_or(s.meshless.rays);
        s.meshless.epsilon = self.epsilon.unwrap_or(s.meshless.epsilon);
        s.max_vertices = if self.no_tessellate { None } else { self.max_vertices.or(s.max_vertices) };
        s
    }

    /// Imports and bakes, with progress on standard error; Ctrl-C leaves a checkpoint.
    ///
    /// # Errors
    /// A scene that cannot be read, options out of range, an output that cannot be written, or Ctrl-C.
    pub fn run(&self, quiet: bool) -> Result<BakeReport> {
        let settings = crate::resolve(self.settings())?;
        if let Some(threads) = self.threads {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
            pool.context("cannot start the worker threads; choose a smaller --threads")?;
        }
        let progress = ProgressReporter::new(if quiet { ProgressStyle::None } else { self.progress });
        progress.cancel_on_interrupt();
        let start = Instant::now();
        let imported = import(&self.scene)?;
        imported.report.warnings.iter().for_each(|w| progress.warn(w));
        let job = BakeJob {
            settings,
            output: self.output.clone(),
            chunks: self.chunks,
            resume: self.resume,
            import_secs: start.elapsed().as_secs_f64(),
            warnings: imported.report.warnings,
        };
        let report = bake(imported.scene, &job, &progress)?.report;
        progress.finish();
        if let Some(path) = &self.report {
            write_json(path, &report)?;
        }
        Ok(report)
    }
}

/// A place from three numbers with commas between.
fn place(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|x| x.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 && Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err("give three numbers with commas between, such as 0,1.5,-2".into()),
    }
}

/// Options of `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// Dataset to describe
    pub file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl InfoArgs {
    /// Prints what a dataset holds.
    ///
    /// # Errors
    /// A dataset that cannot be read.
    pub fn run(&self) -> Result<()> {
        let dataset = Dataset::read(&self.file)?;
        if self.json { print_out(&json_text(&info_json(&dataset))?) } else { print_out(&info_text(&dataset)) }
    }
}

fn info_json(dataset: &Dataset) -> serde_json::Value {
    let scene = &dataset.scene;
    serde_json::json!({
        "settings": dataset.settings,
        "report": dataset.report,
        "scene_hash": dataset.scene_hash,
        "materials": scene.materials.iter().map(|m| &m.name).collect::<Vec<_>>(),
        "objects": scene.objects.iter().map(|o| &o.name).collect::<Vec<_>>(),
        "textures": scene.textures.iter().map(|t| &t.name).collect::<Vec<_>>(),
        "cameras": scene.cameras,
    })
}

fn info_text(dataset: &Dataset) -> String {
    let (r, s, scene) = (&dataset.report, &dataset.settings, &dataset.scene);
    let size = scene.mesh.bounds().max - scene.mesh.bounds().min;
    let mut text = format!(
        "mesh       {} vertices, {} triangles, {:.2} x {:.2} x {:.2} m\n",
        r.vertices, r.triangles, size.x, size.y, size.z
    );
    text += &format!(
        "scene      {} objects, {} materials, {} textures, {} cameras\n",
        scene.objects.len(),
        scene.materials.len(),
        scene.textures.len(),
        scene.cameras.len()
    );
    if s.mode.environment() {
        text += &format!("light tree {} samples, {:?}, beta {}\n", r.lights, s.tree, s.beta);
        text += &format!("cuts       {:.1} nodes on average, {} at most, sigma {}\n", r.mean_cut, r.max_cut, r.sigma);
        text += &format!("error      {:.4} RMS of visibility\n", r.rms_visibility);
    } else {
        text += "cuts       not baked: the environment is dark\n";
    }
    text += &r.indirect.as_ref().map_or(String::new(), |indirect| indirect_text(indirect, s));
    text += &r.meshless.as_ref().map_or(String::new(), meshless_text);
    text += &format!(
        "size       {:.1} MB of cuts, {:.1} MB in all\n",
        r.bytes_cuts as f64 / 1e6,
        r.bytes_total as f64 / 1e6
    );
    text += &format!(
        "bake       {:.1} s, {:.1} million samples a second\n",
        r.seconds.get("total").unwrap_or(&0.0),
        r.samples_per_second / 1e6
    );
    for warning in &r.warnings {
        text += &format!("warning    {warning}\n");
    }
    text
}

fn indirect_text(r: &IndirectReport, s: &BakeSettings) -> String {
    let [x, y, z] = r.viewpoint;
    format!(
        "sources    {} on {:.1} m², {:.3} m apart, reached from {x:.2}, {y:.2}, {z:.2}\n\
         seen       {:.1} nodes on average, {} at most, sigma {}, {:.1} % error of solid angles, {:.1} MB\n",
        r.sources,
        r.area,
        r.radius,
        r.mean_cut,
        r.max_cut,
        s.indirect.criterion.sigma,
        100.0 * r.relative_error,
        r.bytes_cuts as f64 / 1e6
    )
}

fn meshless_text(r: &MeshlessReport) -> String {
    format!(
        "meshless   {} functions on {} levels, {} of them send\n\
         links      {}, {:.3} % of the possible ones, {:.1} MB with points\n",
        r.functions.iter().sum::<usize>(),
        r.functions.len(),
        r.senders,
        r.links,
        100.0 * r.share,
        (r.bytes_links + r.bytes_points) as f64 / 1e6
    )
}

/// Options of `verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Dataset to verify
    pub file: PathBuf,
    /// Vertices to trace again, picked at random but always the same
    #[arg(long, value_name = "K", default_value_t = 256)]
    pub vertices: usize,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl VerifyArgs {
    /// Traces random vertices again and prints the difference.
    ///
    /// # Errors
    /// A dataset that cannot be read, or that does not agree with what was traced.
    pub fn run(&self) -> Result<()> {
        let result = crate::verify(&Dataset::read(&self.file)?, self.vertices);
        if self.json {
            print_out(&json_text(&result)?)?;
        } else {
            print_out(&verification_text(&result))?;
        }
        if !result.passed {
            bail!("the dataset does not agree with its scene: bake it again");
        }
        Ok(())
    }
}

fn verification_text(v: &Verification) -> String {
    let mut text = String::new();
    if v.vertices > 0 || v.source_vertices == 0 {
        text += &format!(
            "traced {} vertices again: RMS of visibility {:.4} (whole bake {:.4}, worst vertex {:.4}), {} cuts differ\n",
            v.vertices, v.rms_visibility, v.expected_rms, v.worst_rms, v.different_cuts
        );
    }
    if v.source_vertices > 0 {
        text += &format!(
            "traced the sources from {} vertices again: {} cuts differ\n",
            v.source_vertices, v.different_source_cuts
        );
    }
    text
}

/// Prints to standard output. A reader that left early is no error, a full disk is.
///
/// # Errors
/// Standard output that cannot be written.
pub fn print_out(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// An error and its causes in one line. Most of our errors tell their cause themselves; it is not said twice.
pub fn error_text(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

fn json_text(value: &impl serde::Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// Writes a value as indented JSON, atomically.
///
/// # Errors
/// A file that cannot be written.
pub fn write_json(path: &std::path::Path, value: &impl serde::Serialize) -> Result<()> {
    lapidary_core::atomic::write_atomically(path, json_text(value)?.as_bytes())
        .with_context(|| format!("cannot write {}; check the folder and the free space", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_three_numbers() {
        assert_eq!(place("0, 1.5,-2"), Ok(Vec3::new(0.0, 1.5, -2.0)));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,x,2,3", "1,2,inf"] {
            assert!(place(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn causes_are_told_once() {
        let cause = || anyhow::anyhow!("no space left");
        assert_eq!(error_text(&cause().context("cannot write")), "cannot write: no space left");
        assert_eq!(
            error_text(&cause().context("cannot write: no space left (a.cuts)")),
            "cannot write: no space left (a.cuts)"
        );
    }
}
