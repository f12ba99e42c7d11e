//! Poisson-disk sets by dart throwing (meshless basis paper, 2.3).

use super::candidates::Candidates;
use crate::{
    errors::PointsError,
    observer::{Event, Observer},
    warning::{BasisWarning, Warning},
};
use glam::Vec3;
use lapidary_core::{
    sphere::{fibonacci_directions, frame_around},
    surfel::{GradedGrid, Surface, Surfel},
};

/// Consecutive rejections after which a set counts as full (2000 in the paper).
const FAILURES: usize = 2000;
/// Squared radius of a set relative to the area per point.
pub(crate) const DENSITY: f32 = 0.79;
/// Rays of the openness test: half the directions of a sphere.
const OPENNESS_RAYS: usize = 32;
/// Largest number of points of a set, for surfaces too large for their radius. A level that ends there causes a warning.
const MOST_POINTS: usize = 4_000_000;
/// Factor for [`poisson_count`] that gives slightly more points than requested.
const USUAL_FACTOR: f32 = 2.0;

/// Criteria of dart throwing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Darts {
    /// Least distance in meters between any two points (Eq. 11).
    pub radius: f32,
    /// Reject points in narrow places: where the harmonic mean distance of surfaces over the hemisphere is below a sixth of the
    /// radius.
    pub open_only: bool,
    /// Stop at this many points.
    pub most: usize,
}

/// A Poisson-disk set of candidates; `placed` receives the growing number of points.
///
/// # Errors
/// [`PointsError::Cancelled`].
pub fn poisson_disk(
    candidates: &mut Candidates,
    darts: Darts,
    placed: impl Fn(usize),
) -> Result<Vec<Surfel>, PointsError> {
    let hemisphere: Vec<Vec3> = fibonacci_directions(2 * OPENNESS_RAYS).into_iter().filter(|d| d.z > 0.0).collect();
    let surface = candidates.surface();
    let is_open = |place: &Surfel| !darts.open_only || !is_narrow(surface, place, darts.radius, &hemisphere);
    let points = throw_darts(candidates, darts.most, |place| is_open(place).then_some(darts.radius), placed)?;
    Ok(points.into_iter().map(|(point, _)| point).collect())
}

/// Candidates at least their radius away from all earlier ones, at most `most`, with their radii in meters. `radius` returns the
/// radius of a point, or `None` if no point may be there; `placed` receives their number.
fn throw_darts(
    candidates: &mut Candidates,
    most: usize,
    radius: impl Fn(&Surfel) -> Option<f32>,
    placed: impl Fn(usize),
) -> Result<Vec<(Surfel, f32)>, PointsError> {
    let mut accepted = GradedGrid::default();
    let mut failures = 0;
    while failures < FAILURES && accepted.points().len() < most {
        let Some(candidate) = candidates.draw()? else { break };
        let is_free = !accepted.any_reaching(&candidate, |_, _| true);
        if let Some(radius) = is_free.then(|| radius(&candidate)).flatten() {
            failures = 0;
            accepted.push(candidate, radius);
            placed(accepted.points().len());
        } else {
            failures += 1;
        }
    }
    Ok(accepted.into_points())
}

/// Whether the harmonic mean distance of the surrounding surfaces, by rays of three radii, is below a sixth of the radius.
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

/// Independent Poisson-disk sets whose radius halves from level to level, the coarsest first. All but the finest avoid
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
    // Coarse functions in narrow places would reach through to the outside. The finest hardly can, and no finer level would replace
    // them.
    let open_only = |level| level + 1 < levels;
    let darts = |level| Darts { radius: radius(level), open_only: open_only(level), most };
    let mut sets: Vec<Vec<Surfel>> = Vec::with_capacity(levels);
    for level in 0..levels {
        let before: usize = sets.iter().map(Vec::len).sum();
        let placed = |points: usize| observer.event(Event::Advanced { done: (before + points) as u64 });
        let points = poisson_disk(&mut candidates, darts(level), placed)?;
        if points.len() >= most {
            let warning = BasisWarning::UncoveredLevel { level: level + 1, points: most };
            observer.event(Event::Warning { message: Warning::Basis(warning) });
        }
        sets.push(points);
    }
    Ok(sets)
}

/// A Poisson-disk set of exactly `count` points with variable radius, and the radius of each in meters.
///
/// `radius` returns the radius at a point for a factor. The search finds a factor that gives slightly more points, and removes the
/// closest ones.
///
/// # Errors
/// Surfaces too small for this many points, or a cancelled job.
pub fn poisson_count(
    candidates: &mut Candidates,
    count: usize,
    radius: impl Fn(&Surfel, f32) -> f32,
) -> Result<Vec<(Surfel, f32)>, PointsError> {
    /// Largest share of removed points.
    const SURPLUS: f32 = 0.06;
    const ATTEMPTS: usize = 16;
    /// Factor below which the search fails.
    const LEAST_FACTOR: f32 = 1e-6;
    let observer = candidates.observer();
    let most = (count as f32 * (1.0 + SURPLUS)) as usize + 1;
    let mut factor = USUAL_FACTOR;
    let mut best: Option<Vec<(Surfel, f32)>> = None;
    for attempt in 0..ATTEMPTS {
        // Each attempt reports half of the remaining progress.
        let [before, part] = [1.0 - (-(attempt as f64)).exp2(), (-(attempt as f64) - 1.0).exp2()];
        let done = |points: usize| before * count as f64 + part * points.min(count) as f64;
        let placed = |points: usize| observer.event(Event::Advanced { done: done(points) as u64 });
        let points = throw_darts(candidates, 2 * most, |place| Some(radius(place, factor)), placed)?;
        let found = points.len();
        if found >= count && best.as_ref().is_none_or(|b| found < b.len()) {
            best = Some(points);
        }
        let good_enough = if attempt < ATTEMPTS / 2 { most } else { 2 * most };
        if best.as_ref().is_some_and(|b| b.len() <= good_enough) {
            break;
        }
        // The number of points is proportional to the inverse square of the radius. The first sets may be far from that law, and
        // the full size of a truncated set is unknown.
        let law = (found.max(1) as f32 / (count as f32 * (1.0 + 0.5 * SURPLUS))).sqrt();
        factor *= if found < 2 * most { law.max(0.02) } else { 2.0 };
        if factor < LEAST_FACTOR {
            break;
        }
    }
    let points = best.ok_or(PointsError::TooLittleSurface { wanted: count })?;
    Ok(thin(points, count))
}

/// Removes the points with the nearest neighbors until `count` are left; only one of two neighbors goes where possible.
fn thin(mut points: Vec<(Surfel, f32)>, count: usize) -> Vec<(Surfel, f32)> {
    while points.len() > count {
        let grid = GradedGrid::of(points.iter().map(|&(point, radius)| (point, 2.0 * radius)));
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

/// The nearest other point that reaches this one: its distance as a share of its own reach, and its index. The point
/// itself if there is none.
fn nearest_other(grid: &GradedGrid, of: usize) -> (f32, usize) {
    let (place, reach) = grid.points()[of];
    let mut nearest = (f32::INFINITY, of);
    grid.any_reaching(&place, |i, d| {
        if i != of && d < nearest.0 {
            nearest = (d, i);
        }
        false
    });
    (nearest.0 / reach, nearest.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn those_are_left_out_that_are_close_for_their_radius() {
        let point = |x: f32, z: f32, radius| (Surfel { position: Vec3::new(x, 0.0, z), ..Default::default() }, radius);
        let grid = |first: f32, cell: f32, radius: f32| {
            (0..100).map(move |i| point(first + cell * (i % 10) as f32, cell * (i / 10) as f32, radius))
        };
        // Twenty additional coarse points, half their proper distance from others but still farther than all fine ones.
        let more = |i| point(0.1 * (i % 10) as f32 + 0.05, 0.2 * (i / 10) as f32, 0.1);
        let fine_left = |radius: f32| {
            let coarse = grid(0.0, 0.1, 0.1).chain((0..20).map(more));
            let left = thin(coarse.chain(grid(3.0, 0.01, radius)).collect(), 200);
            assert_eq!(left.len(), 200);
            left.iter().filter(|(point, _)| point.position.x >= 3.0).count()
        };
        assert_eq!(fine_left(0.01), 100);
        assert!(fine_left(0.04) < 90, "negative control: they are closer for a larger radius");
    }
}
