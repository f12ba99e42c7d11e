//! The points of all levels of the meshless basis (meshless paper, 2.3).

use crate::{
    errors::{BakeError, LEAST_COARSE_RADIUS, PointsError},
    observer::Observer,
    sources::{
        candidates::Candidates,
        disk::{Darts, poisson_disk, poisson_levels},
    },
};
use glam::Vec3;
use lapidary_core::{dataset::MeshlessSettings, meshless::Basis, surfel::Surface};

/// Seed of the points.
const SEED: u64 = 1;

/// Places the functions and returns them with the radius of the coarsest disks.
pub fn place_basis(
    surface: &dyn Surface,
    viewpoint: Vec3,
    settings: &MeshlessSettings,
    observer: &dyn Observer,
) -> Result<(Basis, f32), BakeError> {
    check_coarse_radius(settings, surface.bounds().diagonal())?;
    let radius = match settings.coarse_radius {
        Some(radius) => radius,
        None => coarse_radius(surface, viewpoint, observer)?,
    };
    let levels = poisson_levels(surface, viewpoint, radius, settings.levels, SEED, observer)?;
    let basis = Basis::new(&levels, radius, settings.sender_levels);
    Ok((basis?, radius))
}

/// Checks that a given radius is not too small for a scene with this diagonal.
pub fn check_coarse_radius(settings: &MeshlessSettings, diagonal: f32) -> Result<(), PointsError> {
    match settings.coarse_radius {
        Some(radius) if !(radius >= LEAST_COARSE_RADIUS * diagonal) => {
            Err(PointsError::RadiusTooSmall { radius, diagonal })
        }
        _ => Ok(()),
    }
}

/// The radius at which about [`MeshlessSettings::COARSEST_FUNCTIONS`] disks fit. Their number is proportional to the inverse square
/// of the radius, but smaller where parts of a scene are smaller than a disk; hence several steps.
fn coarse_radius(surface: &dyn Surface, viewpoint: Vec3, observer: &dyn Observer) -> Result<f32, PointsError> {
    let mut candidates = Candidates::new(surface, viewpoint, SEED, observer)?;
    let mut radius = 0.05 * surface.bounds().diagonal();
    for _ in 0..3 {
        let darts = Darts { radius, open_only: true, most: 1 << 16 };
        let count = poisson_disk(&mut candidates, darts, |_| ())?.len().max(1);
        radius *= (count as f32 / MeshlessSettings::COARSEST_FUNCTIONS as f32).sqrt();
    }
    Ok(radius)
}
