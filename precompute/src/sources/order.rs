//! The tree of the surface sources.

use super::sampler::{SourceSampler, SourceScratch};
use crate::{
    errors::BakeError,
    observer::Observer,
    vertices::{
        pilot::pilot_of,
        points::{BakePoint, BakePoints},
        visibility::{EXHAUSTIVE, FINEST},
    },
};
use lapidary_core::{
    dataset::BakeSettings,
    light_tree::{Features, PilotVisibility, TreeKind, cluster_order},
    ray::{Intersector, OPEN},
    sources::Source,
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;

/// Arranges sources as the leaves of their complete binary tree, by position and normal, by pilot visibility, or by both.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn order_sources(
    sources: Vec<Source>,
    points: &BakePoints,
    scene: &Intersector,
    surface: &dyn Surface,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<Vec<Source>, BakeError> {
    let diagonal = surface.bounds().diagonal();
    let none = PilotVisibility { lights: sources.len(), fractions: Vec::new() };
    // By position first, because the pilot's batches need neighbors in the array to be neighbors in space.
    let sources = clustered(&sources, TreeKind::Geometric, 1.0, diagonal, &none);
    if settings.tree == TreeKind::Geometric {
        return Ok(sources);
    }
    // Uses the finest probes, because there is no audit yet: missed light makes the tree slightly worse, and no cut wrong.
    let sources_per_probe = if settings.exhaustive { EXHAUSTIVE } else { FINEST };
    let sampler = SourceSampler::new(scene, &sources, surface.offset(), sources_per_probe);
    let scratch = || (SourceScratch::default(), vec![0.0; sources.len()]);
    let row = |(scratch, solid_angles): &mut (SourceScratch, Vec<f32>), point: &&BakePoint| {
        sampler.sample(point, scratch, solid_angles);
        solid_angles.iter().map(|&angle| if angle > 0.0 { OPEN } else { 0 }).collect()
    };
    let rows = |points: &[&BakePoint]| Ok(points.par_iter().map_init(scratch, row).collect());
    let pilot = pilot_of(points, diagonal, sources.len(), settings.pilot_clusters, observer, rows)?;
    Ok(clustered(&sources, settings.tree, settings.beta, diagonal, &pilot))
}

fn clustered(sources: &[Source], kind: TreeKind, beta: f32, diagonal: f32, pilot: &PilotVisibility) -> Vec<Source> {
    let surfels: Vec<Surfel> = sources.iter().map(|s| s.surfel).collect();
    let order = cluster_order(&Features::of_surfels(kind, beta, &surfels, diagonal, pilot));
    order.into_iter().map(|i| sources[i as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bake::settings::Preset,
        observer::Silent,
        sources::placement::place_sources,
        test_scenes::{Prepared, room},
    };
    use glam::Vec3;

    #[test]
    fn trees_of_all_kinds_hold_every_source_and_keep_neighbours_together() {
        let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
        let sources = place_sources(&prepared.surface(), Vec3::new(0.1, 0.7, 0.15), 2048, &[], &Silent).unwrap();
        let points = BakePoints::new(&prepared.scene.mesh, &prepared.sides);
        let key = |s: &Source| s.surfel.position.to_array().map(f32::to_bits);
        let spread = |sources: &[Source]| {
            let node = |s: &[Source]| {
                let mean = s.iter().map(|s| s.surfel.position).sum::<Vec3>() / s.len() as f32;
                s.iter().map(|s| s.surfel.position.distance(mean)).sum::<f32>() / s.len() as f32
            };
            sources.chunks(32).map(node).sum::<f32>() / (sources.len() / 32) as f32
        };
        for tree in [TreeKind::Geometric, TreeKind::DataDriven, TreeKind::Mixed] {
            let settings = BakeSettings { tree, pilot_clusters: 16, ..Preset::Draft.settings() };
            let surface = prepared.surface();
            let ordered =
                order_sources(sources.clone(), &points, &prepared.intersector, &surface, &settings, &Silent).unwrap();
            let sorted = |s: &[Source]| {
                let mut keys: Vec<_> = s.iter().map(key).collect();
                keys.sort_unstable();
                keys
            };
            assert_eq!(sorted(&ordered), sorted(&sources));
            assert!(spread(&ordered) < 0.4 * spread(&sources), "{tree:?}: {}", spread(&ordered));
        }
    }
}
