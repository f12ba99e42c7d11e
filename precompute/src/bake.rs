//! The bake, phase by phase.

mod bounces;
mod chunks;
mod clock;
mod fit;
mod geometry;
mod indirect;
mod meshless;
mod pack;
mod remarks;

pub(crate) use geometry::Geometry;
pub(crate) use pack::{Packed, concatenate, pack};

use self::{
    bounces::bake_bounces,
    chunks::{EnvironmentCuts, bake_chunks},
    clock::Clock,
    fit::fit_environment,
    pack::unbaked,
    remarks::Remarks,
};
use crate::{
    checkpoint::{Checkpoint, Chunk, Series},
    errors::{BakeError, SettingsError, cancelled},
    memory,
    meshless::check_coarse_radius,
    observer::{Event, Observer, Phase},
    pilot::sample_pilot,
    settings::resolve,
    visibility::VisibilitySampler,
};
use lapidary_core::{
    dataset::{BakeReport, BakeSettings, Dataset, scene_hash},
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    scene::Scene,
    sphere::fibonacci_directions,
};
use std::{path::PathBuf, time::Instant};

/// Bake points of one chunk unless asked for otherwise: a second or two of work to lose.
const POINTS_PER_CHUNK: usize = 4096;

/// What to bake, and how to go about it.
#[derive(Clone, Debug)]
pub struct BakeJob {
    /// What decides the result; see [`crate::resolve`].
    pub settings: BakeSettings,
    /// Where the dataset goes; checkpoints lie beside it.
    pub output: PathBuf,
    /// Number of chunks; `None` for a checkpoint every few seconds.
    pub chunks: Option<usize>,
    /// Go on from the checkpoint of an interrupted bake.
    pub resume: bool,
    /// Seconds that the import took, for the report.
    pub import_secs: f64,
    /// What the import remarked, for the report.
    pub warnings: Vec<String>,
}

/// Bakes a scene and writes the dataset to the job's output.
///
/// # Errors
/// See [`BakeError`]. Whatever stood at the output is kept unless the bake succeeds.
pub fn bake(scene: Scene, job: &BakeJob, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    let settings = resolve(job.settings.clone())?;
    let remarks = Remarks::before(observer);
    let observer: &dyn Observer = &remarks;
    check_memory(&scene, &settings)?;
    if settings.mode.meshless() {
        check_coarse_radius(&settings.meshless, scene.mesh.bounds().diagonal())?;
    }
    let hash = scene_hash(&scene);
    let mut clock = Clock::new(observer, job.import_secs);
    let vertices = scene.mesh.positions.len().max(settings.max_vertices.unwrap_or(0)) as u64;
    let geometry = clock.time(Phase::Tessellate, vertices, "vertices", || {
        Geometry::new(scene, settings.mode, settings.max_vertices, &settings.shots, observer)
    })?;
    cancelled(observer)?;
    let (checkpoint, tree) = prepare(&geometry, job, &settings, &hash, &mut clock)?;
    let chunks = bake_environment(&geometry, &tree, &settings, &checkpoint, &mut clock)?;
    let bounces = bake_bounces(&geometry, &tree, &settings, &checkpoint, &mut clock)?;
    observer.event(Event::Started { phase: Phase::Pack, total: 0, unit: "bytes" });
    let packing = Instant::now();
    let (cuts, sigma) = fit_environment(concatenate(&chunks), tree.height(), &settings, observer);
    let packed = pack(cuts, &chunks, geometry.points.of_vertex.iter().copied(), Series::Environment)?;
    let report = report(&geometry, &settings, &packed, job.warnings.clone());
    let report = BakeReport { sigma, indirect: bounces.report, meshless: bounces.meshless_report, ..report };
    let vertex_valid = geometry.points.of_vertex.iter().map(|&p| !geometry.buried[p as usize]).collect();
    let two_sided = geometry.sides.two_sided;
    let mut dataset = Dataset {
        scene: geometry.scene,
        two_sided,
        vertex_valid,
        tree,
        cuts: packed.cuts,
        indirect: bounces.indirect,
        meshless: bounces.meshless,
        settings,
        scene_hash: hash,
        report,
    };
    clock.add(Phase::Pack, packing.elapsed());
    finish_report(&mut dataset, clock);
    dataset.report.warnings.extend(remarks.warnings());
    dataset.write(&job.output)?;
    checkpoint.remove()?;
    Ok(dataset)
}

/// What the bake points see of distant light, or nothing if that is not asked for.
fn bake_environment(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &BakeSettings,
    checkpoint: &Checkpoint,
    clock: &mut Clock,
) -> Result<Vec<Chunk>, BakeError> {
    let points = &geometry.points.points;
    if !settings.mode.environment() {
        return Ok(unbaked(points.len()));
    }
    let maker = EnvironmentCuts {
        points,
        sampler: VisibilitySampler::new(&geometry.intersector, tree),
        height: tree.height(),
        criterion: settings.criterion,
    };
    let observer = clock.observer;
    clock.time(Phase::Visibility, points.len() as u64, "points", || {
        bake_chunks(&maker, Series::Environment, checkpoint, observer)
    })
}

fn check_memory(scene: &Scene, settings: &BakeSettings) -> Result<(), BakeError> {
    let vertices = scene.mesh.positions.len().max(settings.max_vertices.unwrap_or(0));
    let triangles = scene.mesh.triangles.len().max(2 * vertices);
    let threads = rayon::current_num_threads();
    let needed = memory::estimate(vertices, triangles, settings, threads);
    match memory::available() {
        Some(available) if needed > available => {
            let remedy = memory::remedy(settings.mode);
            Err(BakeError::Memory { remedy, needed: needed >> 20, available: available >> 20 })
        }
        _ => Ok(()),
    }
}

/// The light tree and the checkpoint: those of an interrupted bake, or new ones.
fn prepare(
    geometry: &Geometry,
    job: &BakeJob,
    settings: &BakeSettings,
    hash: &str,
    clock: &mut Clock,
) -> Result<(Checkpoint, LightTree), BakeError> {
    let points = geometry.points.points.len();
    if job.resume
        && let Some(checkpoint) = Checkpoint::open(&job.output, hash, settings)?
    {
        if checkpoint.points() == points
            && let Ok(tree) = LightTree::from_order(checkpoint.tree_order().to_vec())
        {
            return Ok((checkpoint, tree));
        }
        let message = "the checkpoint has other bake points or another light tree than this bake and is discarded: all is \
                       baked again";
        clock.observer.event(Event::Warning { message: message.into() });
    }
    if !job.resume && Checkpoint::folder_of(&job.output).exists() {
        let message = "an unfinished bake of this output is discarded; pass --resume to go on with it instead".into();
        clock.observer.event(Event::Warning { message });
    }
    let tree = build_tree(geometry, settings, clock)?;
    let chunks = job.chunks.unwrap_or_else(|| points.div_ceil(POINTS_PER_CHUNK));
    let checkpoint = Checkpoint::create(&job.output, hash, settings, points, chunks, tree.order())?;
    Ok((checkpoint, tree))
}

fn build_tree(geometry: &Geometry, settings: &BakeSettings, clock: &mut Clock) -> Result<LightTree, BakeError> {
    let observer = clock.observer;
    // A tree that nothing is baked over needs no pilot.
    let kind = if settings.mode.environment() { settings.tree } else { TreeKind::Geometric };
    let pilot = if kind == TreeKind::Geometric {
        PilotVisibility { lights: settings.lights, fractions: Vec::new() }
    } else {
        let diagonal = geometry.scene.mesh.bounds().diagonal();
        let (lights, clusters) = (settings.lights, settings.pilot_clusters);
        clock.time(Phase::Pilot, clusters as u64, "clusters", || {
            sample_pilot(&geometry.points, &geometry.intersector, diagonal, lights, clusters, observer)
        })?
    };
    clock.time(Phase::Tree, settings.lights as u64, "lights", || {
        let directions = fibonacci_directions(settings.lights);
        let features = Features::of_kind(kind, settings.beta, &directions, &pilot);
        Ok(LightTree::build(&features).map_err(SettingsError::from)?)
    })
}

/// What a bake did, but for what only its phases know. `import_warnings` are the remarks of the import.
pub(crate) fn report(
    geometry: &Geometry,
    settings: &BakeSettings,
    packed: &Packed,
    import_warnings: Vec<String>,
) -> BakeReport {
    let points = geometry.points.points.len();
    let pairs = if settings.mode.environment() { points as u64 * settings.lights as u64 } else { 0 };
    let buried_points = geometry.buried.iter().filter(|&&b| b).count();
    BakeReport {
        vertices: geometry.scene.mesh.positions.len(),
        triangles: geometry.scene.mesh.triangles.len(),
        lights: settings.lights,
        tree: settings.tree,
        beta: settings.beta,
        mean_cut: packed.mean_cut(),
        max_cut: packed.max_cut,
        rms_visibility: (packed.squared_error / pairs.max(1) as f64).sqrt(),
        bytes_cuts: packed.bytes(),
        samples_resolved: pairs,
        rays_traced: packed.rays,
        bake_points: points,
        buried_points,
        source_vertices: geometry.source_vertices,
        cut_size_histogram: packed.histogram.clone(),
        mode: settings.mode,
        warnings: import_warnings,
        ..Default::default()
    }
}

fn finish_report(dataset: &mut Dataset, clock: Clock) {
    dataset.report.bytes_total = dataset.tensor_bytes();
    dataset.report.seconds = clock.finish();
    let secs = dataset.report.seconds.get(Phase::Visibility.name()).copied().unwrap_or(0.0);
    dataset.report.samples_per_second = dataset.report.samples_resolved as f64 / secs.max(1e-9);
    dataset.report.peak_memory_bytes = memory::peak();
}

#[cfg(test)]
mod tests;
