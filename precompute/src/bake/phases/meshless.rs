//! The phases of the meshless basis: its points, and the light transport between its functions.

use super::bounces::Bouncing;
use crate::{
    bake::{
        checkpoint::{Places, Series},
        clock::Clock,
    },
    errors::BakeError,
    meshless::{points::place_basis, transport::resumable_operator},
    observer::{Event, Phase},
    warning::{BasisWarning, Warning},
};
use lapidary_core::{dataset::MeshlessReport, meshless::MeshlessBake};

impl Bouncing<'_> {
    /// Both phases of the basis, each timed. A resumed bake places the points again. If they are unchanged, it takes the finished
    /// links from the checkpoint.
    pub fn bake_meshless(&self, clock: &mut Clock) -> Result<(MeshlessBake, MeshlessReport), BakeError> {
        let Self { surface, viewpoint, settings, checkpoint, .. } = *self;
        let settings = &settings.meshless;
        let observer = clock.observer;
        let (basis, radius) = clock.time(Phase::Basis, settings.expected_functions(), "points", || {
            place_basis(surface, viewpoint, settings, observer)
        })?;
        if basis.level(0).len() < 2 {
            observer.event(Event::Warning { message: Warning::Basis(BasisWarning::FewFunctions) });
        }
        let kept = checkpoint.series(Series::Transport, Places::of(basis.points(), basis.radii()));
        let (transport, report) = clock.time(Phase::Transport, basis.len() as u64, "functions", || {
            resumable_operator(surface, &basis, settings, &kept, observer)
        })?;
        if kept.has_met_others() {
            observer.event(Event::Warning { message: Warning::Basis(BasisWarning::Other) });
        }
        let report = MeshlessReport { viewpoint: viewpoint.into(), coarse_radius: radius, ..report };
        Ok((MeshlessBake { basis, transport }, report))
    }
}
