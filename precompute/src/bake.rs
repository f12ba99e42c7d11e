//! The bake, phase by phase.

use crate::{
    CheckpointError, PointsError, SettingsError,
    bake_points::BakePoints,
    checkpoint::{Checkpoint, Chunk},
    memory,
    observer::{Event, Observer, Phase},
    pilot::sample_pilot,
    sidedness::{Sidedness, classify},
    tessellate::tessellate,
    visibility::VisibilitySampler,
};
use lapidary_core::{
    cut::{
        CutSelector,
        packed::{NODES_PER_TEXEL, PackedCuts, TEXTURE_WIDTH},
        prune,
    },
    dataset::{BakeReport, BakeSettings, Dataset, DatasetError, scene_hash},
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    ray::Intersector,
    scene::Scene,
    sphere::fibonacci_directions,
};
use rayon::prelude::*;
use std::{collections::BTreeMap, path::PathBuf, time::Instant};
use thiserror::Error;

/// Bake points of one chunk unless asked for otherwise: a second or two of work to lose.
const POINTS_PER_CHUNK: usize = 4096;
/// Bake points between two looks at the observer.
const POINTS_PER_STEP: usize = 256;

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

/// Why a bake did not finish.
#[derive(Debug, Error)]
pub enum BakeError {
    /// The observer asked for it.
    #[error("the bake was cancelled; run the same command with --resume to go on from the last finished chunk")]
    Cancelled,
    /// Settings out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The checkpoint cannot be used or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// Points cannot be placed on the surfaces.
    #[error(transparent)]
    Points(#[from] PointsError),
    /// The dataset cannot be written.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// More memory than there is.
    #[error(
        "the bake needs about {needed} MB of memory, {available} MB are free; lower --max-vertices or close other programs"
    )]
    Memory {
        /// Estimated need.
        needed: u64,
        /// Free now.
        available: u64,
    },
    /// More texels than a texture holds.
    #[error("the cuts take {texels} texels, a texture holds {limit}; raise --sigma or set --max-cut")]
    TooManyTexels {
        /// Texels needed.
        texels: usize,
        /// Texels of an 8192 x 8192 texture.
        limit: usize,
    },
}

/// Bakes a scene and writes the dataset to the job's output.
///
/// # Errors
/// See [`BakeError`]. Whatever stood at the output is kept unless the bake succeeds.
pub fn bake(scene: Scene, job: &BakeJob, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    let settings = crate::resolve(job.settings.clone())?;
    check_memory(&scene, &settings)?;
    let hash = scene_hash(&scene);
    let mut clock = Clock::new(observer, job.import_secs);
    let geometry = clock.time(Phase::Tessellate, scene.mesh.positions.len() as u64, "vertices", || {
        Geometry::new(scene, settings.max_vertices, observer)
    })?;
    cancelled(observer)?;
    let (checkpoint, tree) = prepare(&geometry, job, &settings, &hash, &mut clock)?;
    let chunks = clock.time(Phase::Visibility, geometry.points.points.len() as u64, "points", || {
        bake_chunks(&geometry, &tree, &settings, &checkpoint, observer)
    })?;
    observer.event(Event::Started { phase: Phase::Pack, total: 0, unit: "bytes" });
    let packing = Instant::now();
    let packed = pack(&geometry.points, chunks, tree.height(), settings.max_bytes, settings.criterion.sigma)?;
    let report = report(&geometry, &settings, &packed, job);
    let vertex_valid = geometry.points.of_vertex.iter().map(|&p| !geometry.buried[p as usize]).collect();
    let two_sided = geometry.sides.two_sided;
    let (scene, cuts) = (geometry.scene, packed.cuts);
    let mut dataset =
        Dataset { scene, two_sided, vertex_valid, tree, cuts, indirect: None, settings, scene_hash: hash, report };
    clock.seconds.insert(Phase::Pack.name().into(), packing.elapsed().as_secs_f64());
    finish_report(&mut dataset, clock);
    dataset.write(&job.output)?;
    checkpoint.remove()?;
    Ok(dataset)
}

fn check_memory(scene: &Scene, settings: &BakeSettings) -> Result<(), BakeError> {
    let vertices = scene.mesh.positions.len().max(settings.max_vertices.unwrap_or(0));
    let triangles = scene.mesh.triangles.len().max(2 * vertices);
    let threads = rayon::current_num_threads();
    let needed = memory::estimate(vertices, triangles, settings.lights, settings.pilot_clusters, threads);
    match memory::available() {
        Some(available) if needed > available => {
            Err(BakeError::Memory { needed: needed >> 20, available: available >> 20 })
        }
        _ => Ok(()),
    }
}

/// An error if the job should stop.
pub(crate) fn cancelled(observer: &dyn Observer) -> Result<(), BakeError> {
    if observer.cancelled() { Err(BakeError::Cancelled) } else { Ok(()) }
}

/// The tessellated scene with its bake points.
struct Geometry {
    scene: Scene,
    source_vertices: usize,
    sides: Sidedness,
    intersector: Intersector,
    points: BakePoints,
    buried: Vec<bool>,
}

impl Geometry {
    fn new(mut scene: Scene, budget: Option<usize>, observer: &dyn Observer) -> Result<Self, BakeError> {
        let source_vertices = scene.mesh.positions.len();
        let mut sides = classify(&scene);
        let source = Intersector::new(&scene.mesh);
        let intersector = match budget {
            Some(budget) => {
                tessellate(&mut scene.mesh, &mut sides, &source, budget, observer)?;
                Intersector::new(&scene.mesh)
            }
            None => source,
        };
        let points = BakePoints::new(&scene.mesh, &sides);
        let buried = points.buried(&intersector, &sides, observer)?;
        Ok(Self { scene, source_vertices, sides, intersector, points, buried })
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
        && checkpoint.points() == points
        && let Ok(tree) = LightTree::from_order(checkpoint.tree_order().to_vec())
    {
        return Ok((checkpoint, tree));
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
    let pilot = if settings.tree == TreeKind::Geometric {
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
        let features = Features::of_kind(settings.tree, settings.beta, &directions, &pilot);
        Ok(LightTree::build(&features).map_err(SettingsError::from)?)
    })
}

fn bake_chunks(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &BakeSettings,
    checkpoint: &Checkpoint,
    observer: &dyn Observer,
) -> Result<Vec<Chunk>, BakeError> {
    let sampler = VisibilitySampler::new(&geometry.intersector, tree);
    let mut chunks = Vec::with_capacity(checkpoint.chunks());
    for index in 0..checkpoint.chunks() {
        let range = checkpoint.range(index);
        let chunk = match checkpoint.load(index) {
            Some(chunk) => chunk,
            None => {
                let chunk = bake_chunk(geometry, tree, settings, &sampler, range.clone(), observer)?;
                checkpoint.store(index, &chunk)?;
                chunk
            }
        };
        observer.event(Event::Advanced { done: range.end as u64 });
        chunks.push(chunk);
    }
    Ok(chunks)
}

fn bake_chunk(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &BakeSettings,
    sampler: &VisibilitySampler,
    range: std::ops::Range<usize>,
    observer: &dyn Observer,
) -> Result<Chunk, BakeError> {
    let mut chunk = Chunk::default();
    let scratch = || (CutSelector::new(tree.height(), settings.criterion), vec![0_u8; tree.len()]);
    for start in range.clone().step_by(POINTS_PER_STEP) {
        cancelled(observer)?;
        let step = &geometry.points.points[start..range.end.min(start + POINTS_PER_STEP)];
        let cuts = step.par_iter().map_init(scratch, |(selector, visible), point| {
            let rays = sampler.sample(point, visible);
            let mut cut = Vec::new();
            let squared_error = selector.select(visible, &mut cut);
            (cut, squared_error, rays)
        });
        // Collected in order: sums do not depend on which thread was first.
        for (cut, squared_error, rays) in cuts.collect::<Vec<_>>() {
            chunk.lengths.push(cut.len() as u32);
            chunk.nodes.extend(cut);
            chunk.squared_error += squared_error;
            chunk.rays += rays;
        }
        observer.event(Event::Advanced { done: (start + step.len()) as u64 });
    }
    Ok(chunk)
}

/// All cuts, and sums over bake points.
struct Packed {
    cuts: PackedCuts,
    sigma: f32,
    nodes: u64,
    max_cut: usize,
    histogram: Vec<u64>,
    squared_error: f64,
    rays: u64,
}

fn pack(
    points: &BakePoints,
    chunks: Vec<Chunk>,
    height: u32,
    max_bytes: Option<u64>,
    sigma: f32,
) -> Result<Packed, BakeError> {
    let squared_error = chunks.iter().map(|c| c.squared_error).sum();
    let rays = chunks.iter().map(|c| c.rays).sum();
    let mut all: Vec<Vec<u16>> = Vec::with_capacity(points.points.len());
    for chunk in chunks {
        let mut rest = &chunk.nodes[..];
        for &length in &chunk.lengths {
            let (cut, after) = rest.split_at(length as usize);
            all.push(cut.to_vec());
            rest = after;
        }
    }
    let (all, sigma) = fit_budget(all, height, max_bytes, sigma);
    let texels: usize = all.iter().map(|c| c.len().div_ceil(NODES_PER_TEXEL)).sum();
    let limit = TEXTURE_WIDTH * TEXTURE_WIDTH;
    if texels > limit {
        return Err(BakeError::TooManyTexels { texels, limit });
    }
    let mut cuts = PackedCuts::default();
    let offsets: Vec<u32> = all.iter().map(|cut| cuts.push_cut(cut)).collect();
    points.of_vertex.iter().for_each(|&p| cuts.push_vertex(offsets[p as usize]));
    let mut histogram = vec![0; height as usize + 1];
    all.iter().for_each(|cut| histogram[cut.len().ilog2() as usize] += 1);
    Ok(Packed {
        cuts,
        sigma,
        nodes: all.iter().map(|c| c.len() as u64).sum(),
        max_cut: all.iter().map(Vec::len).max().unwrap_or(0),
        histogram,
        squared_error,
        rays,
    })
}

/// Coarsens all cuts by a common sigma, the smallest of a geometric series that fits the bytes.
fn fit_budget(cuts: Vec<Vec<u16>>, height: u32, max_bytes: Option<u64>, sigma: f32) -> (Vec<Vec<u16>>, f32) {
    let bytes =
        |cuts: &[Vec<u16>]| cuts.iter().map(|c| (c.len().next_multiple_of(NODES_PER_TEXEL) * 2) as u64).sum::<u64>();
    let (mut fitted, mut coarser) = (cuts, sigma.max(0.25));
    let Some(budget) = max_bytes else { return (fitted, sigma) };
    if bytes(&fitted) <= budget {
        return (fitted, sigma);
    }
    const STEP: f32 = 1.05;
    while bytes(&fitted) > budget && fitted.iter().any(|c| c.len() > 1) {
        coarser *= STEP;
        fitted = fitted.par_iter().map(|cut| prune(height, coarser, cut)).collect();
    }
    (fitted, coarser)
}

fn report(geometry: &Geometry, settings: &BakeSettings, packed: &Packed, job: &BakeJob) -> BakeReport {
    let points = geometry.points.points.len();
    let pairs = points as u64 * settings.lights as u64;
    let buried_points = geometry.buried.iter().filter(|&&b| b).count();
    BakeReport {
        vertices: geometry.scene.mesh.positions.len(),
        triangles: geometry.scene.mesh.triangles.len(),
        lights: settings.lights,
        tree: settings.tree,
        beta: settings.beta,
        sigma: packed.sigma,
        mean_cut: packed.nodes as f64 / points.max(1) as f64,
        max_cut: packed.max_cut,
        rms_visibility: (packed.squared_error / pairs.max(1) as f64).sqrt(),
        bytes_cuts: (2 * packed.cuts.nodes().len() + 4 * packed.cuts.offsets().len()) as u64,
        samples_resolved: pairs,
        rays_traced: packed.rays,
        bake_points: points,
        buried_points,
        source_vertices: geometry.source_vertices,
        cut_size_histogram: packed.histogram.clone(),
        warnings: job.warnings.clone(),
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

/// Announces phases and keeps their times.
struct Clock<'a> {
    observer: &'a dyn Observer,
    start: Instant,
    seconds: BTreeMap<String, f64>,
}

impl<'a> Clock<'a> {
    fn new(observer: &'a dyn Observer, import_secs: f64) -> Self {
        let mut seconds: BTreeMap<String, f64> =
            [Phase::Tessellate, Phase::Pilot, Phase::Tree, Phase::Visibility, Phase::Pack]
                .map(|p| (p.name().to_owned(), 0.0))
                .into();
        seconds.insert(Phase::Import.name().into(), import_secs);
        Self { observer, start: Instant::now(), seconds }
    }

    fn time<T>(&mut self, phase: Phase, total: u64, unit: &'static str, work: impl FnOnce() -> T) -> T {
        self.observer.event(Event::Started { phase, total, unit });
        let start = Instant::now();
        let result = work();
        self.seconds.insert(phase.name().into(), start.elapsed().as_secs_f64());
        result
    }

    fn finish(mut self) -> BTreeMap<String, f64> {
        let total = self.start.elapsed().as_secs_f64() + self.seconds["import"];
        self.seconds.insert("total".into(), total);
        self.seconds
    }
}

#[cfg(test)]
mod tests;
