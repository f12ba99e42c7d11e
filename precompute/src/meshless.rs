//! The meshless bake: points of all levels, then the operator between them (meshless paper, 2.3 and 3.2).

use crate::{
    errors::{BakeError, LEAST_COARSE_RADIUS, PointsError},
    observer::Observer,
    surface_points::{Candidates, Darts, poisson_disk, poisson_levels},
    transport::transport_operator,
};
use glam::Vec3;
use lapidary_core::{
    dataset::{MeshlessReport, MeshlessSettings},
    meshless::{Basis, MeshlessBake},
    surfel::Surface,
};

/// Seed of the points.
const SEED: u64 = 1;

/// Places points on all surfaces from which light reaches the viewpoint, and computes the operator between the functions
/// around them. The surface may be of any kind.
///
/// # Errors
/// [`BakeError::Points`] for a viewpoint that sees nothing or a coarse radius that is too small, [`BakeError::Basis`] for
/// settings that contradict each other, [`BakeError::Cancelled`].
pub fn meshless_bake(
    surface: &dyn Surface,
    viewpoint: Vec3,
    settings: &MeshlessSettings,
    observer: &dyn Observer,
) -> Result<(MeshlessBake, MeshlessReport), BakeError> {
    let (basis, radius) = place_basis(surface, viewpoint, settings, observer)?;
    let (transport, report) = transport_operator(surface, &basis, settings, observer)?;
    let report = MeshlessReport { viewpoint: viewpoint.into(), coarse_radius: radius, ..report };
    Ok((MeshlessBake { basis, transport }, report))
}

/// The functions, and the distance of the coarsest ones.
pub(crate) fn place_basis(
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

/// An error if a radius is asked for that is too small for a scene of this diagonal.
pub(crate) fn check_coarse_radius(settings: &MeshlessSettings, diagonal: f32) -> Result<(), PointsError> {
    match settings.coarse_radius {
        Some(radius) if !(radius >= LEAST_COARSE_RADIUS * diagonal) => {
            Err(PointsError::RadiusTooSmall { radius, diagonal })
        }
        _ => Ok(()),
    }
}

/// The radius at which about [`MeshlessSettings::COARSEST_FUNCTIONS`] disks fit. Their number goes with its inverse square,
/// less so where the parts of a scene are smaller than a disk, hence a few steps.
fn coarse_radius(surface: &dyn Surface, viewpoint: Vec3, observer: &dyn Observer) -> Result<f32, PointsError> {
    let mut candidates = Candidates::new(surface, viewpoint, SEED, observer)?;
    let mut radius = 0.05 * surface.bounds().diagonal();
    for _ in 0..3 {
        let darts = Darts { radius, open_only: true, most: 1 << 16 };
        let count = poisson_disk(&mut candidates, darts)?.len().max(1);
        radius *= (count as f32 / MeshlessSettings::COARSEST_FUNCTIONS as f32).sqrt();
    }
    Ok(radius)
}

#[cfg(test)]
mod tests;
