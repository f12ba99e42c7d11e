//! Positions of surface sources (paper, 4.1). Points of the meshless basis paper replace the paper's repulsion of random points.

use super::{areas::sample_areas, candidates::Candidates, disk::poisson_count, spacing::Spacing};
use crate::{errors::PointsError, observer::Observer};
use glam::Vec3;
use lapidary_core::{mesh_surface::MeshSurface, shot::Shot, sources::Source};

/// Seed of the particles: the same scene gets the same sources.
const POINTS_SEED: u64 = 0x736f_7572_6365_7301;
/// Seed of the particles that measure the spacing of sources.
const SPACING_SEED: u64 = 0x736f_7572_6365_7303;
/// Seed of the points that estimate areas.
pub const AREAS_SEED: u64 = 0x736f_7572_6365_7302;

/// Units of progress of [`place_sources`]: placing each source, and measuring its area.
pub fn placement_units(count: usize) -> u64 {
    2 * count as u64
}

/// `count` sources on the surfaces that light reaches from the viewpoint. They are denser near close receivers, above all near
/// receivers in the shots.
///
/// # Errors
/// See [`poisson_count`].
pub fn place_sources(
    surface: &MeshSurface,
    viewpoint: Vec3,
    count: usize,
    shots: &[Shot],
    observer: &dyn Observer,
) -> Result<Vec<Source>, PointsError> {
    let mut candidates = Candidates::new(surface, viewpoint, SPACING_SEED, observer)?.for_shots(shots);
    let spacing = Spacing::new(&mut candidates, count)?;
    let mut candidates = Candidates::new(surface, viewpoint, POINTS_SEED, observer)?.for_shots(shots);
    let samples = poisson_count(&mut candidates, count, |place, factor| spacing.at(place, factor))?;
    let areas = sample_areas(surface, &samples, AREAS_SEED, observer)?;
    let source = |((surfel, spacing), area)| Source { surfel, area, spacing };
    Ok(samples.into_iter().zip(areas).map(source).collect())
}
