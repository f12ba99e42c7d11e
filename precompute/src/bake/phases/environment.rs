//! The phase of distant light: its tracing method, the bake points' visibility, and their cuts.

use super::{
    audit::audit_environment,
    chunks::{EnvironmentCuts, bake_chunks},
    geometry::Geometry,
    point_cuts::PointCuts,
};
use crate::{
    bake::{checkpoint::Kept, clock::Clock, settings::ResolvedBake},
    errors::BakeError,
    observer::{Event, Phase},
    vertices::{
        tracing::{ManySampler, Tracing},
        visibility::EXHAUSTIVE,
    },
    warning::Warning,
};
use lapidary_core::{dataset::BakeAudit, light_tree::LightTree, ray::RayDevices};

/// Visibility of distant light.
pub struct EnvironmentVisibility<'a> {
    /// The cuts of the bake points.
    pub cuts: PointCuts<'a>,
    pub audit: Option<BakeAudit>,
    /// Whether a device traced it.
    pub on_device: bool,
}

impl EnvironmentVisibility<'_> {
    /// Lights per probe, see [`Tracing`].
    pub fn lights_per_probe(&self) -> usize {
        self.audit.map_or(EXHAUSTIVE, |audit| audit.leaves_per_probe)
    }
}

/// Visibility of distant light from the bake points, if requested; `kept` has the finished chunks. A known audit is reused.
pub fn bake_environment<'a>(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &ResolvedBake,
    known: Option<BakeAudit>,
    devices: Option<&dyn RayDevices>,
    kept: &'a Kept<'a>,
    clock: &mut Clock,
) -> Result<EnvironmentVisibility<'a>, BakeError> {
    let points = &geometry.points.points;
    if !settings.mode.environment() {
        return Ok(EnvironmentVisibility { cuts: PointCuts::unbaked(points.len()), audit: None, on_device: false });
    }
    let observer = clock.observer;
    clock.time(Phase::Visibility, points.len() as u64, "points", || {
        let audit = match known {
            Some(audit) => Some(audit),
            None => audit_environment(points, &geometry.intersector, tree, settings, (devices, observer))?,
        };
        let lights_per_probe = audit.map_or(EXHAUSTIVE, |audit| audit.leaves_per_probe);
        let tracing = Tracing { lights_per_probe, devices, observer };
        let maker = EnvironmentCuts {
            points,
            sampler: ManySampler::new(&geometry.intersector, tree.leaf_directions(), tracing),
            height: tree.height(),
            criterion: settings.criterion,
        };
        let cuts = bake_chunks(&maker, kept, observer)?;
        if kept.has_met_others() {
            observer.event(Event::Warning { message: Warning::OtherCheckpoint });
        }
        Ok(EnvironmentVisibility { cuts, audit, on_device: maker.sampler.is_on_device() })
    })
}
