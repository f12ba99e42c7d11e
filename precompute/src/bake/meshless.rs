//! The phases of the meshless basis: its points, and the light transport between its functions.

use super::{BakeError, clock::Clock};
use crate::{
    checkpoint::Checkpoint,
    meshless::place_basis,
    observer::{Event, Phase},
    transport::resumable_operator,
};
use glam::Vec3;
use lapidary_core::{
    dataset::{MeshlessReport, MeshlessSettings},
    meshless::MeshlessBake,
    surfel::Surface,
};

/// Both phases, each timed. When a bake is resumed the points are placed again, which depends on the settings alone, and
/// the finished links are taken from the checkpoint.
pub(super) fn bake_meshless(
    surface: &dyn Surface,
    viewpoint: Vec3,
    settings: &MeshlessSettings,
    checkpoint: &Checkpoint,
    clock: &mut Clock,
) -> Result<(MeshlessBake, MeshlessReport), BakeError> {
    let observer = clock.observer;
    let (basis, radius) =
        clock.time(Phase::Basis, 0, "points", || place_basis(surface, viewpoint, settings, observer))?;
    if basis.level(0).len() < 2 {
        let message =
            "the meshless basis has almost no functions: light reaches hardly any surface; give a place inside \
                       the scene with --viewpoint x,y,z"
                .into();
        observer.event(Event::Warning { message });
    }
    let (transport, report) = clock.time(Phase::Transport, basis.len() as u64, "functions", || {
        resumable_operator(surface, &basis, settings, checkpoint, observer)
    })?;
    let report = MeshlessReport { viewpoint: viewpoint.into(), coarse_radius: radius, ..report };
    Ok((MeshlessBake { basis, transport }, report))
}
