//! The area that each surface point represents: the part of the reachable surface closer to it than to other points.

use super::disk::DENSITY;
use crate::{
    errors::PointsError,
    observer::{Event, Observer},
    warning::{SourcesWarning, Warning},
};
use lapidary_core::{
    mesh_surface::MeshSurface,
    sources::OWNED_WITHIN,
    surfel::{GradedGrid, Surface, Surfel},
};
use rayon::prelude::*;

/// Uniformly distributed points per sample in one draw.
const POINTS_PER_SAMPLE: usize = 64;
/// Mean number of owned points per sample at which drawing ends: each area is accurate to a seventh, and their sum to far less.
const OWNED_PER_SAMPLE: usize = 48;
/// Largest number of draws. If light reaches a hundredth of the scene, samples end with 40 points each.
const DRAWS: usize = 64;
/// Largest number of further draws around densely placed samples, which would otherwise own too few points.
const FINE_DRAWS: usize = 16;
/// Nearest samples tried as the owner of a point: an object on a surface may separate the point from the nearest.
const TRIED: usize = 4;
/// Owned points per sample below which a warning is given.
const FEW: usize = 16;
/// Share of samples without area above which a warning is given.
const WITHOUT_AREA: f32 = 0.01;

/// Areas in m² of the samples of a Poisson-disk set, given with their radii.
///
/// Uniformly distributed points of the mesh are assigned by Eq. 11 to the nearest visible sample within two radii. So enclosed
/// surfaces do not count, not even a floor beneath a box with a sample close outside its wall. Coincident faces count once. Points
/// are drawn until enough of them are assigned, because a room may be a small part of a building.
///
/// # Errors
/// [`PointsError::Cancelled`].
pub fn sample_areas(
    surface: &MeshSurface,
    samples: &[(Surfel, f32)],
    seed: u64,
    observer: &dyn Observer,
) -> Result<Vec<f32>, PointsError> {
    let mut census = Census::new(surface, samples, seed, observer);
    while census.draws < DRAWS && census.owned() < samples.len() * OWNED_PER_SAMPLE {
        census.draw(|_| true, |_| true)?;
    }
    let owned = census.owned();
    let draws: Vec<usize> = samples.iter().map(|&(_, radius)| census.draws_for(radius)).collect();
    for draw in census.draws..draws.iter().copied().max().unwrap_or(0) {
        let is_fine = |sample: usize| draws[sample] > draw;
        let fine = grid_of(samples.iter().enumerate().filter(|(i, _)| is_fine(*i)).map(|(_, sample)| sample));
        census.draw(|point| fine.any_reaching(point, |_, _| true), is_fine)?;
    }
    remark(&census.points_of, owned, observer);
    let area = |(points, draws): (&u32, &usize)| *points as f32 * census.area_of_point / *draws.max(&1) as f32;
    Ok(census.points_of.iter().zip(&draws).map(area).collect())
}

/// A grid of samples, each with the reach within which it may own points.
fn grid_of<'a>(samples: impl Iterator<Item = &'a (Surfel, f32)>) -> GradedGrid {
    GradedGrid::of(samples.map(|&(sample, radius)| (sample, OWNED_WITHIN * radius)))
}

/// Points of the mesh, each assigned to its owner.
struct Census<'a> {
    surface: &'a MeshSurface<'a>,
    observer: &'a dyn Observer,
    seed: u64,
    grid: GradedGrid,
    points_of: Vec<u32>,
    draws: usize,
    /// Area per point of one draw, in m².
    area_of_point: f32,
}

impl<'a> Census<'a> {
    fn new(surface: &'a MeshSurface<'a>, samples: &[(Surfel, f32)], seed: u64, observer: &'a dyn Observer) -> Self {
        let (grid, points_of) = (grid_of(samples.iter()), vec![0; samples.len()]);
        Self { surface, observer, seed, grid, points_of, draws: 0, area_of_point: 0.0 }
    }

    /// Draws points that satisfy `may_count`, and assigns them to owners that satisfy `counts`.
    fn draw(
        &mut self,
        may_count: impl Fn(&Surfel) -> bool + Sync,
        counts: impl Fn(usize) -> bool,
    ) -> Result<(), PointsError> {
        if self.observer.cancelled() {
            return Err(PointsError::Cancelled);
        }
        let Self { surface, grid, .. } = self;
        let number = self.points_of.len() * POINTS_PER_SAMPLE;
        let (points, area_of_point) = surface.uniform_points(number, self.seed + self.draws as u64);
        let owner = |point: &Surfel| may_count(point).then(|| owner(surface, grid, point)).flatten();
        let owners: Vec<Option<u32>> = points.par_iter().map(owner).collect();
        for sample in owners.into_iter().flatten().filter(|&sample| counts(sample as usize)) {
            self.points_of[sample as usize] += 1;
        }
        self.draws += 1;
        self.area_of_point = area_of_point;
        // After all samples are placed.
        let measured = self.owned() / OWNED_PER_SAMPLE;
        self.observer.event(Event::Advanced { done: (self.points_of.len() + measured) as u64 });
        Ok(())
    }

    fn owned(&self) -> usize {
        self.points_of.iter().map(|&points| points as usize).sum()
    }

    /// Draws that give a sample enough points, at least the draws for all samples. The number depends on the radius rather than on
    /// the points found so far, which would favor lucky samples.
    fn draws_for(&self, radius: f32) -> usize {
        let enough = (OWNED_PER_SAMPLE as f32 * DENSITY * self.area_of_point / (radius * radius)).ceil();
        (enough as usize).clamp(self.draws, self.draws + FINE_DRAWS)
    }
}

/// Warns of noisy areas.
fn remark(points_of: &[u32], owned: usize, observer: &dyn Observer) {
    let (samples, without) = (points_of.len(), points_of.iter().filter(|&&n| n == 0).count());
    let warn = |warning| observer.event(Event::Warning { message: Warning::Sources(warning) });
    if owned < FEW * samples {
        warn(SourcesWarning::UnevenAreas { points: owned as f32 / samples as f32 });
    }
    if without as f32 > WITHOUT_AREA * samples as f32 {
        warn(SourcesWarning::WithoutArea { without, sources: samples });
    }
}

/// The nearest sample that owns a point.
fn owner(surface: &MeshSurface, grid: &GradedGrid, point: &Surfel) -> Option<u32> {
    let mut near: Vec<(f32, u32)> = Vec::new();
    grid.any_reaching(point, |i, distance| {
        near.push((distance, i as u32));
        false
    });
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let owner =
        near.into_iter().map(|n| n.1).take(TRIED).find(|&i| belongs(surface, point, &grid.points()[i as usize]));
    owner.filter(|_| surface.is_outermost(point))
}

/// Whether a point and a sample that reaches it lie on one surface, with nothing in between.
fn belongs(surface: &MeshSurface, point: &Surfel, (sample, reach): &(Surfel, f32)) -> bool {
    let ends = [point, sample];
    let lifted = |s: &Surfel, lift: f32| s.position + s.normal * lift;
    let reaches = |lift: f32| surface.sees(lifted(ends[0], lift), lifted(ends[1], lift));
    let (low, high) = (4.0 * surface.offset(), 0.25 / OWNED_WITHIN * reach);
    // A wall close behind tiles does not belong to them, nor the floor under a cupboard to a sample in front of it.
    let is_open = |s: &Surfel| surface.sees(lifted(s, low), lifted(s, high));
    if reaches(low) {
        is_open(point) || !is_open(sample)
    } else {
        // Above bulges between both.
        is_open(point) && is_open(sample) && reaches(high)
    }
}
