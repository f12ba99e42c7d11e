//! The area that each surface point stands for: that of the reachable surface nearer to it than to the others.

use super::disk::DENSITY;
use crate::{
    errors::PointsError,
    mesh_surface::MeshSurface,
    observer::{Event, Observer},
    warning::Warning,
};
use lapidary_core::{
    sources::OWNED_WITHIN,
    surfel::{GradedGrid, Surface, Surfel},
};
use rayon::prelude::*;

/// Uniformly distributed points a sample that are drawn at a time.
const POINTS_PER_SAMPLE: usize = 64;
/// Points a sample that belong to one, on average, after which no more are drawn: areas are good to a seventh, their sum to
/// far less.
const OWNED_PER_SAMPLE: usize = 48;
/// Draws at most. Where light reaches a hundredth of the scene, samples own 40 points each in the end.
const DRAWS: usize = 64;
/// Further draws at most, around samples that are closer together than others and would own too few points.
const FINE_DRAWS: usize = 16;
/// Samples that are asked in turn whether a point belongs to them: things that stand on a surface part it from the nearest.
const TRIED: usize = 4;
/// Owned points a sample below which it is remarked upon.
const FEW: usize = 16;
/// Samples without any area above which that is remarked upon, as a share.
const WITHOUT_AREA: f32 = 0.01;

/// Areas in m² of the samples of a Poisson-disk set, which come with their radii.
///
/// Uniformly distributed points of the mesh are given to the sample nearest by Eq. 11, of those within two radii that see
/// them, so that enclosed surfaces count for nothing: not even a floor beneath a box beside whose wall a
/// sample lies. Faces that lie in one another count once. Points are drawn until enough of them count: a room may be a small part
/// of a building.
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

/// Samples by the places that may be theirs.
fn grid_of<'a>(samples: impl Iterator<Item = &'a (Surfel, f32)>) -> GradedGrid {
    GradedGrid::of(samples.map(|&(sample, radius)| (sample, OWNED_WITHIN * radius)))
}

/// Points of the mesh, each given to the sample that it belongs to.
struct Census<'a> {
    surface: &'a MeshSurface<'a>,
    observer: &'a dyn Observer,
    seed: u64,
    grid: GradedGrid,
    points_of: Vec<u32>,
    draws: usize,
    /// In m², of one draw.
    area_of_point: f32,
}

impl<'a> Census<'a> {
    fn new(surface: &'a MeshSurface<'a>, samples: &[(Surfel, f32)], seed: u64, observer: &'a dyn Observer) -> Self {
        let (grid, points_of) = (grid_of(samples.iter()), vec![0; samples.len()]);
        Self { surface, observer, seed, grid, points_of, draws: 0, area_of_point: 0.0 }
    }

    /// Draws points, and gives those that may belong to samples that count to these.
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
        Ok(())
    }

    fn owned(&self) -> usize {
        self.points_of.iter().map(|&points| points as usize).sum()
    }

    /// How many draws give a sample enough points: no fewer than those that all have had. It goes by the radius and not by the
    /// points found so far, which would favour lucky ones.
    fn draws_for(&self, radius: f32) -> usize {
        let enough = (OWNED_PER_SAMPLE as f32 * DENSITY * self.area_of_point / (radius * radius)).ceil();
        (enough as usize).clamp(self.draws, self.draws + FINE_DRAWS)
    }
}

/// Tells of areas that are noise.
fn remark(points_of: &[u32], owned: usize, observer: &dyn Observer) {
    let (samples, without) = (points_of.len(), points_of.iter().filter(|&&n| n == 0).count());
    let warn = |message| observer.event(Event::Warning { message });
    if owned < FEW * samples {
        warn(Warning::UnevenAreas { points: owned as f32 / samples as f32 });
    }
    if without as f32 > WITHOUT_AREA * samples as f32 {
        warn(Warning::WithoutArea { without, sources: samples });
    }
}

/// The nearest sample that a point belongs to.
fn owner(surface: &MeshSurface, grid: &GradedGrid, point: &Surfel) -> Option<u32> {
    let mut near: Vec<(f32, u32)> = Vec::new();
    grid.any_reaching(point, |i, distance| {
        near.push((distance, i as u32));
        false
    });
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.dedup();
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
    // A wall close behind tiles is none of theirs, and the floor under a cupboard none of what lies before it.
    let is_open = |s: &Surfel| surface.sees(lifted(s, low), lifted(s, high));
    if reaches(low) {
        is_open(point) || !is_open(sample)
    } else {
        // Over what bulges between the two.
        is_open(point) && is_open(sample) && reaches(high)
    }
}
