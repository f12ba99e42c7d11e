//! The report of a bake.

use super::{
    clock::Clock,
    phases::{geometry::Geometry, pack::Packed},
    settings::ResolvedBake,
};
use crate::observer::Phase;
use lapidary_core::{
    dataset::{BakeReport, BakeRun, Dataset},
    memory,
};

/// The report of a bake, without data known only to its phases. `import_warnings` are the warnings of the import.
pub fn report(
    geometry: &Geometry,
    settings: &ResolvedBake,
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

/// Adds final data: bytes, times, memory.
pub fn finish_report(dataset: &mut Dataset, clock: Clock, estimated_memory_bytes: Option<u64>) {
    dataset.report.bytes_total = dataset.tensor_bytes();
    let seconds = clock.finish();
    let secs = seconds.get(Phase::Visibility.name()).copied().unwrap_or(0.0);
    let samples_per_second = dataset.report.samples_resolved as f64 / secs.max(1e-9);
    let peak_memory_bytes = memory::peak();
    dataset.report.run = Some(BakeRun { seconds, samples_per_second, peak_memory_bytes, estimated_memory_bytes });
}
