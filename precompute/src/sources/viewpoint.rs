//! The one valid viewpoint, which separates reachable surfaces from enclosed ones.
//!
//! A viewpoint should lie in the largest space that is nearly closed: light stays in it and hardly depends on the outside. The
//! score of a point combines the share of directions that hit a surface, the area and number of scene parts that particles reach,
//! and the size of the surrounding space. By directions alone the inside of a column, or a gap between two leaves, would beat any
//! room. Spaces between walls and under roofs may also be large and closed, but there particles hit backs, or few objects; a space
//! meant to be seen is furnished.

use super::candidates::{check_viewpoint, particle_hits};
use crate::errors::PointsError;
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    lights::{Emission, Light},
    mesh_surface::MeshSurface,
    sphere::{cosine_direction, fibonacci_directions, frame_around},
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;
use std::collections::HashSet;

/// Rays that judge a viewpoint.
const RAYS: usize = 256;
/// One of this many rays continues as a particle, up to this many hits.
const RAYS_PER_PARTICLE: usize = 4;
const MOST_HITS: usize = 12;
/// Cells along the diagonal of the scene. The surface in a cell counts once per axis direction that it faces.
const CELLS: f32 = 24.0;
/// Points of a grid along each axis of the search.
const PLACES: usize = 8;
/// The grid extends this far beyond the bounds, relative to their extent: for a model on a plane, all points inside are too close.
const GRID_MARGIN: f32 = 0.25;
/// Random points halfway between opposite surfaces: half of them uniform over the surface, half in detailed places.
const CHORDS: usize = 512;
/// Score relative to the best at which a camera or light serves as viewpoint: it need not be central. Backs around a camera are
/// meant to be seen, and do not count against it.
const GOOD_HINT: f32 = 0.3;
/// Power of the share of front hits: any room shows a few leaves and curtains from behind, but in a space between walls at least a
/// quarter of the hits are backs.
const FRONTS_POWER: i32 = 6;
/// Factor for a point that sees only backs of two-sided surfaces: the sides of a mesh may be wrong.
const BACKS_ONLY: f32 = 0.01;
const SEED: u64 = 0x7669_6577_706f_696e;

/// The surfaces around a point.
pub struct ViewpointSurroundings {
    /// Share of all directions that hit no surface, front or back: 0 in a closed space, about one half over a plane.
    pub open: f32,
    /// Whether light bounces off the surface in every direction.
    pub closed: bool,
    /// Visible surfaces in evenly spread directions.
    pub seen: Vec<Surfel>,
}

impl ViewpointSurroundings {
    /// Examines a point.
    pub fn of(surface: &MeshSurface, place: Vec3) -> Self {
        let View { hits, seen } = View::from(surface, place);
        let open = 1.0 - hits as f32 / RAYS as f32;
        Self { open, closed: seen.len() == RAYS, seen: seen.into_iter().map(|s| s.1).collect() }
    }
}

/// The requested viewpoint; else the first camera or local light with a score of at least 0.3 of the best; else the point with the
/// best score.
///
/// # Errors
/// A requested viewpoint inside a solid or without visible surfaces, or a scene without a valid one.
pub fn find_viewpoint(
    surface: &MeshSurface,
    asked: Option<Vec3>,
    cameras: &[Camera],
    lights: &[Light],
) -> Result<Vec3, PointsError> {
    if let Some(viewpoint) = asked {
        if viewpoint.is_finite() && View::from(surface, viewpoint).inside_solid() {
            return Err(PointsError::InsideSolid(viewpoint));
        }
        return check_viewpoint(surface, viewpoint).map(|()| viewpoint);
    }
    let mut places: Vec<Vec3> = cameras.iter().map(|c| c.eye).collect();
    places.extend(lights.iter().filter_map(|light| place_of(light, surface.offset())));
    let hints = places.len();
    places.extend(grid(surface));
    places.extend(middles_of_chords(surface));
    let scores: Vec<Score> = places.par_iter().map(|&place| Score::of(surface, place)).collect();
    let total = |place: usize| scores[place].total();
    let best = (0..scores.len()).max_by(|&a, &b| total(a).total_cmp(&total(b)).then(b.cmp(&a)));
    let best = best.filter(|&best| total(best) > 0.0).ok_or(PointsError::NoViewpoint)?;
    let is_good = |&hint: &usize| match hint < cameras.len() {
        true => scores[hint].space >= GOOD_HINT * scores[best].space,
        false => total(hint) >= GOOD_HINT * total(best),
    };
    Ok(places[(0..hints).find(is_good).unwrap_or(best)])
}

/// Position of a light, moved off the surface it may lie on.
fn place_of(light: &Light, offset: f32) -> Option<Vec3> {
    match light.emission {
        Emission::Directional { .. } => None,
        Emission::Point => Some(light.position),
        Emission::Spot { .. } | Emission::Rectangle { .. } => {
            Some(light.position + light.forward().unwrap_or(Vec3::ZERO) * (4.0 * offset))
        }
    }
}

/// A grid over the bounds and somewhat beyond.
fn grid(surface: &MeshSurface) -> impl Iterator<Item = Vec3> {
    let bounds = surface.bounds();
    let extent = (bounds.max - bounds.min).max(Vec3::splat(0.02 * bounds.diagonal()));
    let share = |i: usize| (i as f32 + 0.5) / PLACES as f32 * (1.0 + 2.0 * GRID_MARGIN) - GRID_MARGIN;
    (0..PLACES.pow(3)).map(move |i| {
        let at = Vec3::new(share(i % PLACES), share(i / PLACES % PLACES), share(i / (PLACES * PLACES)));
        // Off the planes of symmetry, which often contain edges and corners.
        bounds.min + extent * (at + Vec3::new(0.011, 0.013, 0.017))
    })
}

/// Midpoints between random points of surfaces and the surfaces in front of them. They reach rooms of any size.
fn middles_of_chords(surface: &MeshSurface) -> Vec<Vec3> {
    let mut rng = fastrand::Rng::with_seed(SEED);
    let mut points = surface.uniform_points(CHORDS / 2, SEED).0;
    points.extend(surface.points_of_random_triangles(CHORDS / 2, SEED));
    let middle = |p: Surfel| {
        let origin = p.position + p.normal * surface.offset();
        let hit = surface.first_hit(origin, frame_around(p.normal) * cosine_direction(rng.f32(), rng.f32()))?;
        Some(0.5 * (origin + hit.position))
    };
    points.into_iter().filter_map(middle).collect()
}

/// Score of a viewpoint. Zero inside solids and without visible surfaces.
#[derive(Clone, Copy, Default)]
struct Score {
    /// The area that particles reach, times the root of the number of its parts, the share of directions that see surfaces, and the
    /// size of the surrounding space.
    space: f32,
    /// Share of hits on fronts.
    fronts: f32,
}

impl Score {
    fn of(surface: &MeshSurface, place: Vec3) -> Self {
        if !place.is_finite() {
            return Self::default();
        }
        let view = View::from(surface, place);
        if view.inside_solid() {
            return Self::default();
        }
        let enclosure = view.seen.len() as f32 / RAYS as f32;
        let reached = view.reached(surface, place);
        let size = view.size(place) / surface.bounds().diagonal();
        let space = reached.cells as f32 * (reached.parts as f32).sqrt() * enclosure * size;
        Self { space, fronts: reached.fronts }
    }

    /// Reduced if particles reach many backs.
    fn total(self) -> f32 {
        self.space * self.fronts.powi(FRONTS_POWER).max(BACKS_ONLY)
    }
}

/// The surfaces visible from a point.
struct View {
    /// Rays that hit anything, from either side.
    hits: usize,
    /// Directions that hit a visible side, and the hits.
    seen: Vec<(Vec3, Surfel)>,
}

impl View {
    fn from(surface: &MeshSurface, place: Vec3) -> Self {
        let directions = fibonacci_directions(RAYS);
        let hits = directions.iter().filter(|&&d| surface.hits_anything(place, d)).count();
        let seen = directions.iter().filter_map(|&d| Some((d, surface.first_hit(place, d)?))).collect();
        Self { hits, seen }
    }

    fn inside_solid(&self) -> bool {
        self.hits > 0 && 2 * self.seen.len() < self.hits
    }

    /// Radius in meters of a ball with the visible volume. Attics are low.
    fn size(&self, place: Vec3) -> f32 {
        let cubes: f32 = self.seen.iter().map(|s| s.1.position.distance(place).powi(3)).sum();
        (cubes / RAYS as f32).cbrt()
    }

    /// The hits of particles from the point.
    fn reached(&self, surface: &MeshSurface, place: Vec3) -> Reached {
        let inverse_cell = CELLS / surface.bounds().diagonal();
        let mut rng = fastrand::Rng::with_seed(SEED);
        let mut hits: Vec<Surfel> = self.seen.iter().map(|s| s.1).collect();
        for (direction, _) in self.seen.iter().step_by(RAYS_PER_PARTICLE) {
            hits.extend(particle_hits(surface, place, *direction, MOST_HITS, &mut rng).skip(1));
        }
        let fronts = hits.iter().filter(|at| !surface.owner(at).back).count();
        Reached {
            cells: hits.iter().map(|at| cell(at, inverse_cell)).collect::<HashSet<_>>().len(),
            parts: hits.iter().map(|at| surface.part(at)).collect::<HashSet<_>>().len(),
            fronts: fronts as f32 / hits.len().max(1) as f32,
        }
    }
}

/// The surfaces that particles from a point reach.
struct Reached {
    /// Cells that contain hits: the area.
    cells: usize,
    /// Parts of the scene with hits.
    parts: usize,
    /// Share of hits on fronts.
    fronts: f32,
}

/// The cell of a point, and which of six directions it faces most.
fn cell(point: &Surfel, inverse_cell: f32) -> ([i32; 3], usize) {
    let axis = point.normal.abs().max_position();
    let faces = 2 * axis + usize::from(point.normal[axis] < 0.0);
    ((point.position * inverse_cell).floor().to_array().map(|x| x as i32), faces)
}

#[cfg(test)]
mod tests;
