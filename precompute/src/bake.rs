//! The bake, phase by phase.

pub(crate) mod checkpoint;
mod clock;
mod job;
pub(crate) mod memory;
mod phases;
mod remarks;
mod report;
pub(crate) mod settings;
mod variant;

pub use job::BakeJob;
pub use phases::geometry::Geometry;

use self::{
    checkpoint::Checkpoint,
    clock::Clock,
    phases::{
        bounces::bake_bounces,
        environment::bake_environment,
        fit::fit_environment,
        light_tree::checkpoint_and_tree,
        pack::{concatenate, pack},
    },
    remarks::Remarks,
    report::{finish_report, report},
    settings::ResolvedBake,
};
use crate::{
    errors::{BakeError, CutsOf, cancelled},
    meshless::points::check_coarse_radius,
    observer::{Event, Observer, Phase},
    warning::Warning,
};
use lapidary_core::{
    dataset::{BakeReport, Dataset, scene_hash},
    lock::OutputLock,
    output::check_output,
    scene::Scene,
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Bakes a scene and writes the dataset to the job's output.
///
/// # Errors
/// See [`BakeError`]. An existing output is kept unless the bake succeeds; one that cannot be written is told at once. One bake at
/// a time writes an output.
pub fn bake(scene: Scene, job: &BakeJob, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    let inputs: Vec<&Path> = job.inputs.iter().map(PathBuf::as_path).collect();
    check_output(&job.output, &inputs)?;
    let settings = &job.settings;
    let remarks = Remarks::before(observer);
    let observer: &dyn Observer = &remarks;
    let _lock = OutputLock::acquire(&job.output)?;
    Checkpoint::is_left(&job.output)?;
    check_memory(&scene, settings)?;
    if settings.mode.meshless() {
        check_coarse_radius(&settings.meshless, scene.mesh.bounds().diagonal())?;
    }
    let hash = scene_hash(&scene);
    let resumed = if job.resume { Checkpoint::open(&job.output, &hash, settings)? } else { None };
    let mut clock = Clock::new(observer, job.import_secs);
    let vertices = scene.mesh.positions.len().max(settings.max_vertices.unwrap_or(0)) as u64;
    let geometry = clock.time(Phase::Tessellate, vertices, "vertices", || {
        Geometry::new(scene, settings.mode, settings.max_vertices, &settings.shots, observer)
    })?;
    cancelled(observer)?;
    let (checkpoint, tree) = checkpoint_and_tree(&geometry, job, &hash, resumed, &mut clock)?;
    let chunks = bake_environment(&geometry, &tree, settings, &checkpoint, &mut clock)?;
    let bounces = bake_bounces(&geometry, &tree, settings, &checkpoint, &mut clock)?;
    observer.event(Event::Started { phase: Phase::Pack, total: 0, unit: "bytes" });
    let packing = Instant::now();
    let (cuts, sigma) = fit_environment(concatenate(&chunks), tree.height(), settings, observer);
    let packed = pack(cuts, &chunks, geometry.points.of_vertex.iter().copied(), CutsOf::Environment)?;
    let report = report(&geometry, settings, &packed, job.warnings.clone());
    let report = BakeReport { sigma, indirect: bounces.report, meshless: bounces.meshless_report, ..report };
    let vertex_valid = geometry.vertex_valid();
    let two_sided = geometry.sides.two_sided;
    let mut dataset = Dataset {
        scene: geometry.scene,
        two_sided,
        vertex_valid,
        tree,
        cuts: packed.cuts,
        indirect: bounces.indirect,
        meshless: bounces.meshless,
        settings: settings.clone().into_settings(),
        scene_hash: hash,
        report,
    };
    clock.add(Phase::Pack, packing.elapsed());
    finish_report(&mut dataset, clock);
    dataset.report.warnings.extend(remarks.warnings());
    dataset.write(&job.output)?;
    if let Some(path) = checkpoint.remove()? {
        observer.event(Event::Warning { message: Warning::KeptFolder { path } });
    }
    Ok(dataset)
}

fn check_memory(scene: &Scene, settings: &ResolvedBake) -> Result<(), BakeError> {
    let vertices = scene.mesh.positions.len().max(settings.max_vertices.unwrap_or(0));
    let triangles = scene.mesh.triangles.len().max(2 * vertices);
    let threads = rayon::current_num_threads();
    let needed = memory::estimate(vertices, triangles, settings, threads);
    match lapidary_core::memory::available() {
        Some(available) if needed > available => {
            Err(BakeError::Memory { mode: settings.mode, needed: needed >> 20, available: available >> 20 })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
