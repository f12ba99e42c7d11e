//! The meshless bake: points of all levels, then the operator between them (meshless paper, 2.3 and 3.2).

pub mod points;
pub mod transport;

use self::{points::place_basis, transport::transport_operator};
use crate::{errors::BakeError, observer::Observer};
use glam::Vec3;
use lapidary_core::{
    dataset::{MeshlessReport, MeshlessSettings},
    meshless::MeshlessBake,
    surfel::Surface,
};

/// Places points on all surfaces from which light reaches the viewpoint, and computes the operator between their functions. The
/// surface may be of any kind.
///
/// # Errors
/// [`BakeError::Points`] for a viewpoint that sees nothing or a coarse radius that is too small, [`BakeError::Basis`]
/// for settings that contradict each other, [`BakeError::Cancelled`].
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

#[cfg(test)]
mod tests;
