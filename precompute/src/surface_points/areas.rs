//! The area that each surface point stands for: that of the reachable surface nearer to it than to the others.

use super::grid::Grid;
use crate::MeshSurface;
use lapidary_core::{
    meshless::distance::distance,
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;

/// Uniformly distributed points a sample.
const POINTS_PER_SAMPLE: usize = 64;

/// Areas in m² of the samples of a Poisson-disk set of `radius`.
///
/// Uniformly distributed points of the mesh are given to the sample nearest by Eq. 11. A point counts only if that is within
/// two radii and sees it, so that enclosed surfaces count for nothing: not even a floor beneath a box beside whose wall a
/// sample lies.
pub fn sample_areas(surface: &MeshSurface, samples: &[Surfel], radius: f32, seed: u64) -> Vec<f32> {
    let grid = Grid::of(2.0 * radius, samples);
    let (points, area) = surface.uniform_points(samples.len() * POINTS_PER_SAMPLE, seed);
    let owners: Vec<Option<u32>> = points.par_iter().map(|p| owner(surface, &grid, p, radius)).collect();
    let mut areas = vec![0.0; samples.len()];
    owners.into_iter().flatten().for_each(|sample| areas[sample as usize] += area);
    areas
}

/// The nearest sample that a point belongs to.
fn owner(surface: &MeshSurface, grid: &Grid, point: &Surfel, radius: f32) -> Option<u32> {
    let mut nearest = (2.0 * radius, None);
    grid.any_near(point.position, |i, sample| {
        let d = distance(sample, point);
        if d < nearest.0 {
            nearest = (d, Some(i));
        }
        false
    });
    let sample = nearest.1?;
    let reaches = |lift: f32| {
        let lifted = |s: &Surfel| s.position + s.normal * lift;
        surface.sees(lifted(point), lifted(&grid.points()[sample]))
    };
    // Close to the surface, or over what bulges between the two.
    (reaches(4.0 * surface.offset()) || reaches(0.25 * radius)).then_some(sample as u32)
}
