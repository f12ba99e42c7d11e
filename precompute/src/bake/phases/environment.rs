//! The phase of distant light: how it is traced, what the bake points see of it, and their cuts.

use super::{
    audit::audit_environment,
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
    vertices::{
        tracing::{ManySampler, Tracing},
        visibility::EXHAUSTIVE,
    },
};
use lapidary_core::{dataset::BakeAudit, light_tree::LightTree, ray::RayDevices};

/// Visibility of distant light.
pub struct EnvironmentVisibility {
    /// The cuts of the bake points.
    pub chunks: Vec<Chunk>,
    pub audit: Option<BakeAudit>,
    /// Whether a device traced it.
    pub on_device: bool,
}

impl EnvironmentVisibility {
    /// How it was traced, see [`Tracing`].
    pub fn lights_per_probe(&self) -> usize {
        self.audit.map_or(EXHAUSTIVE, |audit| audit.lights_per_probe)
    }
}

/// Visibility of distant light from the bake points, if it is asked for. An audit that is known is not made again.
pub fn bake_environment(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &ResolvedBake,
    known: Option<BakeAudit>,
    devices: Option<&dyn RayDevices>,
    checkpoint: &Checkpoint,
    clock: &mut Clock,
) -> Result<EnvironmentVisibility, BakeError> {
    let points = &geometry.points.points;
    if !settings.mode.environment() {
        return Ok(EnvironmentVisibility { chunks: vec![unbaked(points.len())], audit: None, on_device: false });
    }
    let observer = clock.observer;
    clock.time(Phase::Visibility, points.len() as u64, "points", || {
        let audit = match known {
            Some(audit) => Some(audit),
            None => audit_environment(geometry, tree, settings, observer)?,
        };
        let mut visibility = EnvironmentVisibility { chunks: Vec::new(), audit, on_device: false };
        let tracing = Tracing { lights_per_probe: visibility.lights_per_probe(), devices };
        let maker = EnvironmentCuts {
            points,
            sampler: ManySampler::new(&geometry.intersector, tree.leaf_directions(), tracing)?,
            height: tree.height(),
            criterion: settings.criterion,
        };
        let kept = checkpoint.series(Series::Environment, Places::of_scene());
        visibility.on_device = maker.sampler.is_on_device();
        visibility.chunks = bake_chunks(&maker, &kept, observer)?;
        Ok(visibility)
    })
}
