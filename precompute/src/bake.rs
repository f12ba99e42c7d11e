//! The bake, phase by phase.

pub(crate) mod checkpoint;
mod clock;
mod job;
pub(crate) mod memory;
mod parts;
mod phases;
mod remarks;
mod report;
pub(crate) mod settings;
pub mod update;
mod variant;

pub use job::BakeJob;
pub use phases::geometry::{Geometry, tessellation_units};

use self::{
    checkpoint::{Checkpoint, Content, Places, Series, Work},
    clock::Clock,
    parts::wavelet::Quads,
    phases::{
        bounces::bake_bounces,
        environment::bake_environment,
        fit::{coarser_environment, fit_environment},
        geometry::ground_budget,
        light_tree::checkpoint_and_tree,
        pack::pack,
    },
    remarks::Remarks,
    report::{finish_report, report},
    settings::{ResolvedBake, resolve},
};
use crate::{
    errors::{BakeError, CutsOf, ShardError, cancelled},
    observer::{Event, Observer, Phase},
    setting::Setting,
    shard::Shard,
    vertices::{tessellate::Stored, tracing::Tracing},
    warning::Warning,
};
use lapidary_core::{
    cut::packed::PackedCuts,
    dataset::{BakeAudit, BakeReport, BakeSettings, Dataset, DecodePicture, bake_hash, scene_hash},
    ground::{Ground, add_ground},
    light_tree::LightTree,
    lock::OutputLock,
    memory::{peak, resident},
    output::check_output,
    ray::RayDevices,
    scene::{
        Scene,
        placed::deformed_hash,
        pose::{Objects, Poses},
    },
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Bakes a scene and writes the dataset to the job's output.
///
/// # Errors
/// See [`BakeError`]. An existing output is kept unless the bake succeeds; an unwritable one is reported at once. Only one
/// bake at a time writes an output.
pub fn bake(scene: Scene, job: &BakeJob, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    bake_on(scene, job, None, observer)
}

/// [`bake`], with the environment's visibility and the pilot of tessellation traced by `devices` if given. Datasets differ only for
/// rays along edges, and for vertices that such rays ask for.
///
/// # Errors
/// See [`bake`]. A device that fails is none: the processor goes on, with a warning.
pub fn bake_on(
    scene: Scene,
    job: &BakeJob,
    devices: Option<&dyn RayDevices>,
    observer: &dyn Observer,
) -> Result<Dataset, BakeError> {
    check_outputs(job)?;
    let remarks = Remarks::before(observer);
    let _lock = OutputLock::acquire(&job.output)?;
    let mut clock = Clock::new(&remarks, job.import_secs);
    check_poses(&scene, &job.poses)?;
    let begun = Begun::new(scene, job, &Work::All, devices, &mut clock)?;
    let (dataset, checkpoint) = begun.dataset(job.warnings.clone(), clock)?;
    let dataset = with_hidden(dataset, &job.poses, &remarks)?;
    finish(dataset, checkpoint, &job.output, &remarks)
}

/// Bakes the share of a shard and leaves it beside the output for [`merge`]. An interrupted share is resumed, and a complete one
/// stays unchanged.
///
/// # Errors
/// See [`BakeError`]. Only one process at a time bakes a share.
pub fn bake_shard(
    scene: Scene,
    job: &BakeJob,
    shard: Shard,
    devices: Option<&dyn RayDevices>,
    observer: &dyn Observer,
) -> Result<BakeReport, BakeError> {
    check_outputs(job)?;
    if job.poses.has_hidden() {
        return Err(ShardError::Hidden.into());
    }
    let remarks = Remarks::before(observer);
    let work = Work::Share(shard);
    let _lock = OutputLock::acquire(&work.folder_of(&job.output))?;
    let mut clock = Clock::new(&remarks, job.import_secs);
    let begun = Begun::new(scene, job, &work, devices, &mut clock)?;
    let before = remarks.warnings();
    let (mut dataset, checkpoint) = begun.dataset(job.warnings.clone(), clock)?;
    let report = dataset.report.clone();
    // The merge repeats the warnings after tessellation.
    dataset.report.warnings.extend(before);
    checkpoint.keep_scene(&without_cuts(dataset))?;
    Ok(report)
}

/// The dataset with fully occluded cuts. Wavelet transport stays, for only the scene as imported has its quads.
fn without_cuts(dataset: Dataset) -> Dataset {
    let mut cuts = PackedCuts::default();
    let offset = cuts.push_cut(&[0]);
    dataset.vertex_valid.iter().for_each(|_| cuts.push_vertex(offset));
    Dataset { cuts, indirect: None, meshless: None, object_bases: None, ..dataset }
}

/// Merges the shares of all shards beside `output` into the dataset, equal to a single bake. Then it removes the shares. `decode`
/// decodes the scene's pictures.
///
/// # Errors
/// Missing, incomplete or unrelated shares; see [`BakeError`]. An existing output and all shares are kept unless the merge
/// succeeds.
pub fn merge(output: &Path, decode: DecodePicture, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    check_output(output, &[])?;
    let remarks = Remarks::before(observer);
    let _lock = OutputLock::acquire(output)?;
    let checkpoint = Checkpoint::of_shares(output)?;
    let _locks = checkpoint.lock_shares()?;
    let scene = checkpoint.scene(decode)?;
    let (hash, warnings, audit) = (scene.scene_hash.clone(), scene.report.warnings.clone(), scene.report.audit);
    let settings = resolve(scene.settings.clone())?;
    let content = bake_hash(&hash, &scene.scene, &scene.scene.placed_poses(), scene.scene.clip_time.as_ref());
    let quads = Quads::of_share(&scene);
    let geometry = Geometry::of_dataset(scene);
    let (points, order) = (geometry.points.points.len(), checkpoint.tree_order().to_vec());
    let tree = LightTree::from_order(order).ok().filter(|_| checkpoint.is_of_scene(&content, &settings, points));
    let tree = tree.ok_or_else(|| checkpoint.foreign_scene())?;
    let begun =
        Begun { settings, hash, geometry, quads, tree, audit, checkpoint, devices: None, estimated_memory: None };
    let (dataset, checkpoint) = begun.dataset(warnings, Clock::new(&remarks, 0.0))?;
    finish(dataset, checkpoint, output, &remarks)
}

/// Hides objects in a finished bake. So their vertices, sources and functions are there when they are shown again.
fn with_hidden(shown: Dataset, poses: &Poses, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    if !poses.has_hidden() {
        return Ok(shown);
    }
    let mut scene = shown.scene.clone();
    // Objects in time have their form from the bake.
    scene.place_again(&poses.without_deformed()).map_err(BakeError::Pose)?;
    let mut hidden = update::update(&shown, scene, observer)?;
    let after = hidden.report.run.take();
    hidden.report.run = shown.report.run.map(|run| run.followed_by(after));
    hidden.report.rays_traced += shown.report.rays_traced;
    Ok(hidden)
}

/// Checks before a bake that objects can be posed and hidden as they will be after it.
fn check_poses(scene: &Scene, poses: &Poses) -> Result<(), BakeError> {
    match poses.has_hidden() {
        true => poses.pose(&scene.mesh, &Objects::of(scene)).map(drop).map_err(BakeError::Pose),
        false => Ok(()),
    }
}

fn check_outputs(job: &BakeJob) -> Result<(), BakeError> {
    let inputs: Vec<&Path> = job.inputs.iter().map(PathBuf::as_path).collect();
    Ok(check_output(&job.output, &inputs)?)
}

/// Writes a dataset and removes its checkpoint.
fn finish(
    mut dataset: Dataset,
    checkpoint: Checkpoint,
    output: &Path,
    remarks: &Remarks,
) -> Result<Dataset, BakeError> {
    dataset.report.warnings.extend(remarks.warnings());
    dataset.write(output)?;
    if let Some(path) = checkpoint.remove()? {
        remarks.event(Event::Warning { message: Warning::KeptFolder { path } });
    }
    Ok(dataset)
}

/// A bake with finished geometry and light tree.
struct Begun<'a> {
    settings: ResolvedBake,
    hash: String,
    geometry: Geometry,
    quads: Quads,
    tree: LightTree,
    /// The audit of its visibility, if already known.
    audit: Option<BakeAudit>,
    checkpoint: Checkpoint,
    devices: Option<&'a dyn RayDevices>,
    /// Bytes, see [`BakeRun::estimated_memory_bytes`](lapidary_core::dataset::BakeRun).
    estimated_memory: Option<u64>,
}

impl<'a> Begun<'a> {
    /// Creates geometry and light tree.
    fn new(
        mut scene: Scene,
        job: &BakeJob,
        work: &Work,
        devices: Option<&'a dyn RayDevices>,
        clock: &mut Clock,
    ) -> Result<Self, BakeError> {
        let settings = job.settings.clone();
        let observer = clock.observer;
        Checkpoint::is_left(&work.folder_of(&job.output))?;
        let estimated_memory = Some(check_memory(&scene, &settings)?);
        let diagonal = scene.mesh.bounds().diagonal();
        parts::of(settings.mode).try_for_each(|part| part.check_scene(&settings, diagonal))?;
        let hash = scene_hash(&scene);
        let content = Content {
            scene_hash: bake_hash(&hash, &scene, &job.poses, job.clip_time.as_ref()),
            deformed_hash: deformed_hash(&job.poses),
        };
        scene.place(&job.poses.all_shown()).map_err(BakeError::Pose)?;
        scene.clip_time.clone_from(&job.clip_time);
        let quads = Quads::of_scene(&scene, &settings, observer)?;
        let vertices = most_vertices(scene.mesh.positions.len(), &settings);
        if settings.ground != Ground::Off {
            add_ground(&mut scene);
        }
        let resumed = match work {
            // A share is always resumed.
            Work::Share(shard) => Checkpoint::open_share(&job.output, *shard, &content, &settings)?,
            _ if job.resume => Checkpoint::open(&job.output, work, &content, &settings)?,
            _ => None,
        };
        let units = tessellation_units(vertices);
        // Shares of several machines have the same vertices and the same tree, whatever traces there.
        let placing = devices.filter(|_| !matches!(work, Work::Share(_)));
        let geometry = clock.time(Phase::Tessellate, units, "points", || {
            let stored = Stored::of(settings.mode).filter(|_| !settings.even_vertices);
            Geometry::new(scene, stored, settings.max_vertices, &settings.shots, placing, observer)
        })?;
        cancelled(observer)?;
        let (checkpoint, tree) = checkpoint_and_tree(&geometry, job, work, content, resumed, placing, clock)?;
        Ok(Self { settings, hash, geometry, quads, tree, audit: None, checkpoint, devices, estimated_memory })
    }

    /// Computes or reads the chunks, and packs them. `warnings` are the earlier ones.
    fn dataset(self, warnings: Vec<String>, mut clock: Clock) -> Result<(Dataset, Checkpoint), BakeError> {
        let Self { settings, hash, geometry, quads, tree, audit, checkpoint, devices, estimated_memory } = self;
        let observer = clock.observer;
        let kept = checkpoint.series(Series::Environment, Places::of(&[], &geometry.points.coordinates()));
        let seen = bake_environment(&geometry, &tree, &settings, audit, devices, &kept, &mut clock)?;
        let tracing = Tracing { lights_per_probe: seen.lights_per_probe(), devices, observer };
        let bounces = bake_bounces(&geometry, &quads, &tree, &settings, tracing, &checkpoint, &mut clock)?;
        observer.event(Event::Started { phase: Phase::Pack, total: 0, unit: "bytes" });
        let packing = Instant::now();
        let (factor, sigma) = fit_environment(&seen.cuts, &settings, observer)?;
        let asked = settings.criterion.sigma;
        let coarser = |cut: &[u16]| coarser_environment(tree.height(), asked, factor.unwrap_or(1.0), cut);
        let coarser = factor.is_some().then_some(&coarser as _);
        let packed = pack(&seen.cuts, coarser, geometry.points.of_vertex.iter().copied(), CutsOf::Environment)?;
        let report = report(&geometry, &settings, &packed, warnings);
        let report = BakeReport { sigma, audit: seen.audit, on_device: seen.on_device, ..report };
        let vertex_valid = geometry.vertex_valid();
        let mut dataset = Dataset {
            scene: geometry.scene,
            two_sided: geometry.sides.two_sided,
            vertex_valid,
            tree,
            cuts: packed.cuts,
            indirect: None,
            meshless: None,
            object_bases: None,
            wavelet: None,
            settings: settings.into_settings(),
            scene_hash: hash,
            report,
        };
        bounces.into_iter().for_each(|put| put(&mut dataset));
        clock.add(Phase::Pack, packing.elapsed());
        finish_report(&mut dataset, clock, estimated_memory);
        Ok((dataset, checkpoint))
    }
}

/// Most vertices in a bake of a scene with `imported` vertices.
pub fn most_vertices(imported: usize, settings: &BakeSettings) -> usize {
    let vertices = imported.max(settings.max_vertices.unwrap_or(0));
    vertices + if settings.ground == Ground::Off { 0 } else { ground_budget(vertices) }
}

/// Checks that there is enough memory. Returns the estimated peak of this process.
fn check_memory(scene: &Scene, settings: &ResolvedBake) -> Result<u64, BakeError> {
    let vertices = most_vertices(scene.mesh.positions.len(), settings);
    let triangles = scene.mesh.triangles.len().max(2 * vertices);
    let threads = rayon::current_num_threads();
    let places_vertices = vertices > scene.mesh.positions.len();
    let needed = memory::estimate(vertices, triangles, places_vertices, settings, threads);
    match lapidary_core::memory::available() {
        Some(available) if needed > available => {
            let sizes: Vec<Setting> = parts::of(settings.mode).filter_map(|part| part.size()).collect();
            let has_cuts = sizes.len() < settings.mode.parts().count();
            Err(BakeError::Memory { sizes, has_cuts, needed: needed >> 20, available: available >> 20 })
        }
        _ => Ok(peak().max(resident() + needed)),
    }
}

#[cfg(test)]
mod tests;
