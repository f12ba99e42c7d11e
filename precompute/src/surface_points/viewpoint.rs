//! The one valid viewpoint that tells reachable surfaces from enclosed ones.

use super::PointsError;
use crate::MeshSurface;
use glam::Vec3;
use lapidary_core::{camera::Camera, sphere::fibonacci_directions, surfel::Surface};
use rayon::prelude::*;

/// Rays that judge a viewpoint.
const RAYS: usize = 256;
/// Places along each axis of the search.
const PLACES: usize = 10;
/// The search goes this far beyond the bounds, as a share of their extent: over a model on a plane, all within is too close.
const BEYOND: f32 = 0.25;

/// Whether particles from a viewpoint land at all.
///
/// # Errors
/// [`PointsError::SeesNothing`].
pub fn check_viewpoint(surface: &dyn Surface, viewpoint: Vec3) -> Result<(), PointsError> {
    let sees = |&d: &Vec3| surface.first_hit(viewpoint, d).is_some();
    let finite = viewpoint.is_finite();
    if finite && fibonacci_directions(RAYS).iter().any(sees) {
        Ok(())
    } else {
        Err(PointsError::SeesNothing(viewpoint))
    }
}

/// The viewpoint asked for, or that of the first camera that has a valid one, or the best of a grid of places: one that is
/// surrounded by fronts of surfaces, not too close.
///
/// # Errors
/// A viewpoint asked for that lies inside a solid or sees nothing; a scene without any valid one.
pub fn find_viewpoint(surface: &MeshSurface, asked: Option<Vec3>, cameras: &[Camera]) -> Result<Vec3, PointsError> {
    let valid = |viewpoint: Vec3| {
        if viewpoint.is_finite() && View::from(surface, viewpoint).inside_solid() {
            return Err(PointsError::InsideSolid(viewpoint));
        }
        check_viewpoint(surface, viewpoint)
    };
    if let Some(viewpoint) = asked {
        return valid(viewpoint).map(|()| viewpoint);
    }
    match cameras.iter().map(|c| c.eye).find(|&eye| valid(eye).is_ok()) {
        Some(eye) => Ok(eye),
        None => search(surface).ok_or(PointsError::NoViewpoint),
    }
}

fn search(surface: &MeshSurface) -> Option<Vec3> {
    let bounds = surface.bounds();
    let share = |i: usize| (i as f32 + 0.5) / PLACES as f32 * (1.0 + 2.0 * BEYOND) - BEYOND;
    let place = |i: usize| {
        let at = Vec3::new(share(i % PLACES), share(i / PLACES % PLACES), share(i / (PLACES * PLACES)));
        // Off the planes of symmetry, where edges and corners tend to lie.
        bounds.min
            + (bounds.max - bounds.min).max(Vec3::splat(0.02 * bounds.diagonal()))
                * (at + Vec3::new(0.011, 0.013, 0.017))
    };
    let score = |i: usize| View::from(surface, place(i)).score(bounds.diagonal());
    let scores: Vec<f32> = (0..PLACES.pow(3)).into_par_iter().map(score).collect();
    let best = (0..scores.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b]).then(b.cmp(&a)))?;
    (scores[best] > 0.0).then(|| place(best))
}

/// What is seen around a place.
struct View {
    /// Rays that meet something, from either side.
    hits: usize,
    /// Distances of what is seen from a side that exists.
    distances: Vec<f32>,
}

impl View {
    fn from(surface: &MeshSurface, place: Vec3) -> Self {
        let directions = fibonacci_directions(RAYS);
        let hits = directions.iter().filter(|&&d| surface.meets_anything(place, d)).count();
        let distance = |&d: &Vec3| surface.first_hit(place, d).map(|s| s.position.distance(place));
        let mut distances: Vec<f32> = directions.iter().filter_map(distance).collect();
        distances.sort_unstable_by(f32::total_cmp);
        Self { hits, distances }
    }

    fn inside_solid(&self) -> bool {
        self.hits > 0 && 2 * self.distances.len() < self.hits
    }

    /// Share of directions that see surfaces, more for medium distances; 0 inside solids and where nothing is seen.
    fn score(&self, diagonal: f32) -> f32 {
        if self.inside_solid() || self.distances.is_empty() {
            return 0.0;
        }
        let quartile = self.distances[self.distances.len() / 4] / diagonal;
        self.distances.len() as f32 / RAYS as f32 + (10.0 * quartile).min(1.0) * 0.5 + 1e-3
    }
}
