//! A trial of the meshless basis.

use super::Tried;
use crate::{
    errors::BakeError,
    meshless::{points::place_basis, transport::transport_operator},
    observer::Silent,
};
use lapidary_core::{dataset::MeshlessSettings, threads::CoreClock};

/// Levels and rays of the basis.
const BASIS: MeshlessSettings =
    MeshlessSettings { levels: 2, sender_levels: 2, coarse_radius: None, rays: 64, epsilon: 0.025 };

/// Result of a trial of the meshless basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasisTrial {
    /// Functions of the first two levels.
    pub functions: usize,
    /// Core seconds per gather ray of a function.
    pub core_secs_per_gather_ray: f64,
}

impl BasisTrial {
    pub(super) fn of(tried: &Tried) -> Result<Self, BakeError> {
        let (basis, _) = place_basis(tried.surface, tried.viewpoint, &BASIS, &Silent)?;
        let start = CoreClock::begin();
        let (_, report) = transport_operator(tried.surface, &basis, &BASIS, &Silent)?;
        let core_secs_per_gather_ray = start.secs() / report.rays_traced.max(1) as f64;
        Ok(Self { functions: basis.len(), core_secs_per_gather_ray })
    }
}
