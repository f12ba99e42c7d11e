//! The phase of distant light: what the bake points see of it, and their cuts.

use super::{
    chunks::{EnvironmentCuts, bake_chunks},
    geometry::Geometry,
    pack::unbaked,
};
use crate::{
    bake::{
        checkpoint::{Checkpoint, Chunk, Places, Series},
        clock::Clock,
        settings::ResolvedBake,
    },
    errors::BakeError,
    observer::Phase,
    vertices::visibility::VisibilitySampler,
};
use lapidary_core::light_tree::LightTree;

/// Visibility of distant light from the bake points, if it is asked for.
pub fn bake_environment(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &ResolvedBake,
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
    let kept = checkpoint.series(Series::Environment, Places::of_scene());
    let observer = clock.observer;
    clock.time(Phase::Visibility, points.len() as u64, "points", || bake_chunks(&maker, &kept, observer))
}
