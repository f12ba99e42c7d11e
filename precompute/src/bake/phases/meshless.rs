//! The phases of the meshless basis: its points, and the light transport between its functions.

use crate::{
    bake::{
        checkpoint::{Checkpoint, Part},
        clock::Clock,
    },
    errors::BakeError,
    meshless::{points::place_basis, transport::resumable_operator},
    observer::{Event, Phase},
};
use glam::Vec3;
use lapidary_core::{
    dataset::{MeshlessReport, MeshlessSettings},
    meshless::MeshlessBake,
    surfel::Surface,
};

/// Both phases, each timed. When a bake is resumed the points are placed again, and if they are those of before, the
/// finished links are taken from the checkpoint.
pub fn bake_meshless(
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
    if checkpoint.bind(Part::Transport, basis.points(), basis.radii())? {
        let message = "the points of the meshless basis lie elsewhere than in the interrupted bake, for cameras, lights or \
                       objects have changed: what was finished of its links is made again";
        observer.event(Event::Warning { message: message.into() });
    }
    let (transport, report) = clock.time(Phase::Transport, basis.len() as u64, "functions", || {
        resumable_operator(surface, &basis, settings, checkpoint, observer)
    })?;
    let report = MeshlessReport { viewpoint: viewpoint.into(), coarse_radius: radius, ..report };
    Ok((MeshlessBake { basis, transport }, report))
}
