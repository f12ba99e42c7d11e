//! The phases of the light tree: pilot visibility and clustering. A resumed bake reuses its tree.

use super::geometry::Geometry;
use crate::{
    bake::{
        checkpoint::{Checkpoint, Content, Work},
        clock::Clock,
        job::BakeJob,
        settings::ResolvedBake,
    },
    errors::{BakeError, SettingsError},
    observer::{Event, Phase},
    vertices::{
        pilot::sample_pilot,
        tracing::{ManySampler, Tracing},
        visibility::{EXHAUSTIVE, FINEST},
    },
    warning::Warning,
};
use lapidary_core::{
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    ray::RayDevices,
    sphere::fibonacci_directions,
};

/// Default number of bake points per chunk, so that at most a second or two of work is lost.
const POINTS_PER_CHUNK: usize = 4096;

/// The light tree and the checkpoint, from the interrupted bake or new.
pub fn checkpoint_and_tree(
    geometry: &Geometry,
    job: &BakeJob,
    work: &Work,
    content: Content,
    resumed: Option<Checkpoint>,
    devices: Option<&dyn RayDevices>,
    clock: &mut Clock,
) -> Result<(Checkpoint, LightTree), BakeError> {
    let (settings, points) = (&job.settings, geometry.points.points.len());
    if let Some(checkpoint) = resumed {
        if checkpoint.points() == points
            && let Ok(tree) = LightTree::from_order(checkpoint.tree_order().to_vec())
        {
            return Ok((checkpoint, tree));
        }
        clock.observer.event(Event::Warning { message: Warning::OtherCheckpoint });
    }
    let tree = build_tree(geometry, settings, devices, clock)?;
    if !job.resume && *work == Work::All && Checkpoint::is_left(&work.folder_of(&job.output))? {
        clock.observer.event(Event::Warning { message: Warning::Discarded });
    }
    let chunks = job.chunks.unwrap_or_else(|| points.div_ceil(POINTS_PER_CHUNK));
    let checkpoint = Checkpoint::create(
        &job.output,
        work,
        content,
        settings,
        points,
        work.chunks(chunks.min(points.max(1))),
        tree.order(),
    )?;
    Ok((checkpoint, tree))
}

fn build_tree(
    geometry: &Geometry,
    settings: &ResolvedBake,
    devices: Option<&dyn RayDevices>,
    clock: &mut Clock,
) -> Result<LightTree, BakeError> {
    let observer = clock.observer;
    let directions = fibonacci_directions(settings.lights);
    // A tree without baked cuts needs no pilot.
    let kind = if settings.mode.environment() { settings.tree } else { TreeKind::Geometric };
    let pilot = if kind == TreeKind::Geometric {
        PilotVisibility { lights: settings.lights, fractions: Vec::new() }
    } else {
        let diagonal = geometry.scene.mesh.bounds().diagonal();
        let clusters = settings.pilot_clusters;
        clock.time(Phase::Pilot, clusters as u64, "clusters", || {
            // Uses the finest probes, because there is no audit yet. Missed light makes the tree slightly worse, and no cut wrong.
            let lights_per_probe = if settings.exhaustive { EXHAUSTIVE } else { FINEST };
            let tracing = Tracing { lights_per_probe, devices, observer };
            let sampler = ManySampler::new(&geometry.intersector, &directions, tracing);
            sample_pilot(&geometry.points, &sampler, diagonal, clusters, observer)
        })?
    };
    clock.time(Phase::Tree, settings.lights as u64, "lights", || {
        let features = Features::of_kind(kind, settings.beta, &directions, &pilot);
        Ok(LightTree::build(&features).map_err(SettingsError::from)?)
    })
}
