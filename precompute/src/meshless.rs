//! The meshless bake: points of all levels, then the operator between them (meshless paper, 2.3 and 3.2).

use crate::{
    BakeError, Candidates, Darts, Event, Observer, Phase, PointsError, poisson_disk, poisson_levels,
    transport::{TransportReport, TransportSettings, transport_operator},
};
use glam::Vec3;
use lapidary_core::{
    meshless::{Basis, MeshlessBake},
    surfel::Surface,
};
use serde::{Deserialize, Serialize};

/// What decides a meshless bake.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshlessSettings {
    /// Levels of functions, 1 to 8.
    pub levels: usize,
    /// How many of the first levels send, at most `levels`.
    pub sender_levels: usize,
    /// Poisson-disk radius of the coarsest level in metres; `None` for the one that has about
    /// [`Self::COARSEST_FUNCTIONS`].
    pub coarse_radius: Option<f32>,
    /// Seed of the points.
    pub seed: u64,
    /// Rays and threshold of the operator.
    pub transport: TransportSettings,
}

impl MeshlessSettings {
    /// The paper's scenes have 176 to 339.
    pub const COARSEST_FUNCTIONS: usize = 250;
}

impl Default for MeshlessSettings {
    /// Those of the paper.
    fn default() -> Self {
        Self { levels: 6, sender_levels: 3, coarse_radius: None, seed: 1, transport: TransportSettings::default() }
    }
}

/// Places the points on all surfaces from which light reaches the viewpoint, and computes the operator.
///
/// # Errors
/// [`BakeError::Points`] for a viewpoint that sees nothing, [`BakeError::Cancelled`].
pub fn meshless_bake(
    surface: &dyn Surface,
    viewpoint: Vec3,
    settings: &MeshlessSettings,
    observer: &dyn Observer,
) -> Result<(MeshlessBake, TransportReport), BakeError> {
    observer.event(Event::Started { phase: Phase::Basis, total: 0, unit: "points" });
    let radius = match settings.coarse_radius {
        Some(radius) => radius,
        None => coarse_radius(surface, viewpoint, settings.seed, observer)?,
    };
    let levels = poisson_levels(surface, viewpoint, radius, settings.levels, settings.seed, observer)?;
    let basis = Basis::new(&levels, radius, settings.sender_levels).map_err(|_| PointsError::SeesNothing(viewpoint))?;
    let (transport, report) = transport_operator(surface, &basis, settings.transport, observer)?;
    Ok((MeshlessBake { basis, transport }, report))
}

/// The radius at which about [`MeshlessSettings::COARSEST_FUNCTIONS`] disks fit: the number goes with the inverse square,
/// less so where the scene's parts are smaller than a disk, hence a second step.
fn coarse_radius(
    surface: &dyn Surface,
    viewpoint: Vec3,
    seed: u64,
    observer: &dyn Observer,
) -> Result<f32, PointsError> {
    let mut candidates = Candidates::new(surface, viewpoint, seed, observer)?;
    let mut radius = 0.05 * surface.bounds().diagonal();
    for _ in 0..3 {
        let darts = Darts { radius, open_only: true, most: usize::MAX };
        let count = poisson_disk(&mut candidates, darts)?.len().max(1);
        radius *= (count as f32 / MeshlessSettings::COARSEST_FUNCTIONS as f32).sqrt();
    }
    Ok(radius)
}
