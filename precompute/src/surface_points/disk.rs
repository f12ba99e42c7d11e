//! Poisson-disk sets by dart throwing (meshless basis paper, 2.3).

use super::{Candidates, PointsError};
use crate::{Event, Observer};
use glam::Vec3;
use lapidary_core::{
    meshless::distance::distance,
    sphere::{fibonacci_directions, frame_around},
    surfel::{Surface, Surfel, SurfelGrid},
};

/// Rejections in a row after which a set counts as full (the paper's 2000).
const FAILURES: usize = 2000;
/// Rays of the openness test; half the directions of a sphere.
const OPENNESS_RAYS: usize = 32;
/// No set is larger: a bound for surfaces too large for their radius. It is told when a level ends there.
const MOST_POINTS: usize = 4_000_000;

/// What dart throwing accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Darts {
    /// Least distance (Eq. 11) of any two points in metres.
    pub radius: f32,
    /// Reject points whose surroundings are nearer than a sixth of the radius, in the harmonic mean over the hemisphere.
    pub open_only: bool,
    /// Stop at this many points.
    pub most: usize,
}

/// A Poisson-disk set of candidates.
///
/// # Errors
/// [`PointsError::Cancelled`].
pub fn poisson_disk(candidates: &mut Candidates, darts: Darts) -> Result<Vec<Surfel>, PointsError> {
    let hemisphere: Vec<Vec3> = fibonacci_directions(2 * OPENNESS_RAYS).into_iter().filter(|d| d.z > 0.0).collect();
    let surface = candidates.surface();
    let mut accepted = SurfelGrid::new(darts.radius);
    let mut failures = 0;
    while failures < FAILURES && accepted.points().len() < darts.most {
        let Some(candidate) = candidates.draw()? else { break };
        let near = accepted.any_near(candidate.position, |_, p| distance(p, &candidate) < darts.radius);
        if near || (darts.open_only && is_narrow(surface, &candidate, darts.radius, &hemisphere)) {
            failures += 1;
        } else {
            failures = 0;
            accepted.push(candidate);
        }
    }
    Ok(accepted.into_points())
}

/// Whether the harmonic mean distance of the surroundings, by rays of three radii, is below a sixth of the radius.
fn is_narrow(surface: &dyn Surface, at: &Surfel, radius: f32, hemisphere: &[Vec3]) -> bool {
    let frame = frame_around(at.normal);
    let origin = at.position + at.normal * surface.offset();
    let longest = 3.0 * radius;
    let inverse_distance = |d: &Vec3| {
        let hit = surface.first_hit(origin, frame * *d);
        1.0 / hit.map_or(longest, |h| h.position.distance(origin).clamp(1e-6 * longest, longest))
    };
    let mean_inverse = hemisphere.iter().map(inverse_distance).sum::<f32>() / hemisphere.len() as f32;
    mean_inverse > 6.0 / radius
}

/// Independent Poisson-disk sets whose radius halves from level to level, the coarsest first; all but the finest keep out of
/// narrow places.
///
/// # Errors
/// A viewpoint that sees nothing, or a cancelled job.
pub fn poisson_levels(
    surface: &dyn Surface,
    viewpoint: Vec3,
    coarse_radius: f32,
    levels: usize,
    seed: u64,
    observer: &dyn Observer,
) -> Result<Vec<Vec<Surfel>>, PointsError> {
    levels_of_at_most(MOST_POINTS, surface, viewpoint, coarse_radius, levels, seed, observer)
}

pub(super) fn levels_of_at_most(
    most: usize,
    surface: &dyn Surface,
    viewpoint: Vec3,
    coarse_radius: f32,
    levels: usize,
    seed: u64,
    observer: &dyn Observer,
) -> Result<Vec<Vec<Surfel>>, PointsError> {
    let mut candidates = Candidates::new(surface, viewpoint, seed, observer)?;
    let radius = |level: usize| coarse_radius * (-(level as f32)).exp2();
    // Coarse functions in narrow places would reach through to what lies outside; the finest hardly can, and nothing finer
    // stands in for them there.
    let open_only = |level| level + 1 < levels;
    let darts = |level| Darts { radius: radius(level), open_only: open_only(level), most };
    let set = |level: usize| {
        let points = poisson_disk(&mut candidates, darts(level))?;
        if points.len() >= most {
            let message = format!(
                "level {} of the meshless basis ends at {most} points, before they cover all surfaces, and light is missing; \
                 give a larger --coarse-radius or fewer --levels",
                level + 1
            );
            observer.event(Event::Warning { message });
        }
        Ok(points)
    };
    (0..levels).map(set).collect()
}

/// A Poisson-disk set of exactly `count` points, and its radius in metres.
///
/// The radius is searched for that gives some more, and the closest of these are left out.
///
/// # Errors
/// A viewpoint that sees nothing, surfaces too small for so many points, or a cancelled job.
pub fn poisson_count(
    surface: &dyn Surface,
    viewpoint: Vec3,
    count: usize,
    seed: u64,
    observer: &dyn Observer,
) -> Result<(Vec<Surfel>, f32), PointsError> {
    /// Points that are left out at most, as a share.
    const SURPLUS: f32 = 0.06;
    const ATTEMPTS: usize = 16;
    let mut candidates = Candidates::new(surface, viewpoint, seed, observer)?;
    let most = (count as f32 * (1.0 + SURPLUS)) as usize + 1;
    let mut radius = 0.02 * surface.bounds().diagonal();
    let mut best: Option<(Vec<Surfel>, f32)> = None;
    for attempt in 0..ATTEMPTS {
        let points = poisson_disk(&mut candidates, Darts { radius, open_only: false, most: 2 * most })?;
        let found = points.len();
        if found >= count && best.as_ref().is_none_or(|(b, _)| found < b.len()) {
            best = Some((points, radius));
        }
        // The number of points goes with the inverse square of the radius; the first sets may be far from that law.
        let good_enough = if attempt < ATTEMPTS / 2 { most } else { 2 * most };
        match &best {
            Some((b, _)) if b.len() <= good_enough => break,
            _ => radius *= (found.max(1) as f32 / (count as f32 * (1.0 + 0.5 * SURPLUS))).sqrt().clamp(0.02, 4.0),
        }
        if !(radius > 1e-7 * surface.bounds().diagonal()) {
            break;
        }
    }
    let (points, radius) = best.ok_or(PointsError::TooLittleSurface { wanted: count })?;
    Ok((thin(points, count, radius), radius))
}

/// Leaves out the points with the nearest neighbours until `count` are left; of two neighbours only one goes where possible.
fn thin(mut points: Vec<Surfel>, count: usize, radius: f32) -> Vec<Surfel> {
    while points.len() > count {
        let grid = SurfelGrid::of(2.0 * radius, &points);
        let mut by_gap: Vec<(f32, u32, u32)> = (0..points.len())
            .map(|i| {
                let (gap, neighbour) = nearest_other(&grid, i);
                (gap, i as u32, neighbour as u32)
            })
            .collect();
        by_gap.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut out, mut held) = (vec![false; points.len()], vec![false; points.len()]);
        let mut surplus = points.len() - count;
        for (_, i, neighbour) in by_gap {
            if surplus > 0 && !held[i as usize] {
                (out[i as usize], held[neighbour as usize]) = (true, true);
                surplus -= 1;
            }
        }
        let mut index = 0;
        points.retain(|_| {
            index += 1;
            !out[index - 1]
        });
    }
    points
}

/// Distance and index of the nearest other point; itself if none is in reach.
fn nearest_other(grid: &SurfelGrid, of: usize) -> (f32, usize) {
    let mut nearest = (f32::INFINITY, of);
    let point = grid.points()[of];
    grid.any_near(point.position, |i, p| {
        let d = if i == of { f32::INFINITY } else { distance(p, &point) };
        if d < nearest.0 {
            nearest = (d, i);
        }
        false
    });
    nearest
}
