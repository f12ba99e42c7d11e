//! Edge length in units of the wanted length at its place.
//!
//! Without shots the unit is constant over the surface. With shots it is constant over their pictures: visible surfaces get most of
//! the vertices, and the rest is spread over all surfaces, for views from elsewhere. On the ground around a scene the unit grows
//! with distance, so that it has a constant angle from the scene.

use super::Wanted;
use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    vertices::spread::on_triangle,
    warning::Warning,
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    ray::Intersector,
    scene::Mesh,
    shot::{Frustum, Shot},
};
use rayon::prelude::*;

/// Share of the vertices for the pictures.
const PICTURES: f32 = 0.8;
/// Limits of the number of points per triangle that are looked up in the pictures.
const PLACES: std::ops::RangeInclusive<f32> = 4.0..=4096.0;
/// Points per ground triangle over which its density is averaged.
const PLACES_OF_MEAN: u32 = 16;
/// Segments from an eye end before a point by this share of their length, so that the point's own surface does not hide it.
const GAP_AT_END: f32 = 1e-4;
/// Rows of rays through a picture that measure its share of surfaces.
const ROWS: u32 = 96;

/// Converts meters to units.
pub(super) struct EdgeScale<'a> {
    scene: &'a Intersector,
    observer: &'a dyn Observer,
    /// Frustums of the shots that see any surface.
    frustums: Vec<Frustum>,
    /// Edge length in meters at which equal triangles over the whole surface would use up the budget.
    pub unit: f32,
    /// Units per meter on surfaces outside all shots.
    unseen: f32,
    /// Units per height of a picture.
    seen: f32,
    falloff: Option<Falloff>,
}

/// Growth of the unit around a scene.
struct Falloff {
    center: Vec3,
    /// Radius in meters within which it does not grow.
    radius: f32,
}

impl Falloff {
    /// Units per meter at a place, relative to the scene.
    fn at(&self, place: Vec3) -> f32 {
        let distance = (place - self.center).with_y(0.0).length();
        self.radius / distance.max(self.radius)
    }

    /// Mean square over a triangle, which scales its effective area.
    fn mean_square(&self, [a, b, c]: [Vec3; 3]) -> f32 {
        let place = |[u, v]: [f32; 2]| a + (b - a) * u + (c - a) * v;
        (0..PLACES_OF_MEAN).map(|i| self.at(place(on_triangle(i))).powi(2)).sum::<f32>() / PLACES_OF_MEAN as f32
    }

    /// Largest value within a triangle.
    fn of_triangle(&self, corners: [Vec3; 3]) -> f32 {
        corners.map(|corner| self.at(corner)).into_iter().fold(0.0, f32::max)
    }
}

impl<'a> EdgeScale<'a> {
    /// Measures a mesh. Warns of shots that see no surface.
    pub fn new(
        mesh: &Mesh,
        scene: &'a Intersector,
        Wanted { shots, budget, around, .. }: Wanted,
        observer: &'a dyn Observer,
    ) -> Self {
        let falloff = around.map(|b| Falloff { center: b.center(), radius: 0.5 * b.diagonal() });
        let share = |t| falloff.as_ref().map_or(1.0, |falloff| falloff.mean_square(mesh.corners(t)));
        let area: f32 = (0..mesh.triangles.len()).map(|t| area_of(mesh, t) * share(t)).sum();
        let unit = edge_length(area, budget as f32);
        let (mut frustums, mut in_pictures) = (Vec::new(), 0.0);
        for (i, shot) in shots.iter().enumerate() {
            let filled = filled_part(shot, scene);
            if filled > 0.0 {
                frustums.push(shot.frustum());
                in_pictures += filled * shot.aspect;
            } else {
                observer.event(Event::Warning { message: Warning::BlindShot(i + 1) });
            }
        }
        let (unseen, seen) = if frustums.is_empty() {
            (unit.recip(), 0.0)
        } else {
            let unit_of = |area, part| edge_length(area, part * budget as f32).recip();
            (unit_of(area, 1.0 - PICTURES), unit_of(in_pictures, PICTURES))
        };
        Self { scene, observer, frustums, unit, unseen, seen, falloff }
    }

    /// Units per meter of each triangle.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn of_triangles(&self, mesh: &Mesh) -> Result<Vec<f32>, BakeError> {
        if let Some(falloff) = &self.falloff {
            let of_triangle = |t| self.unseen * falloff.of_triangle(mesh.corners(t));
            return Ok((0..mesh.triangles.len()).map(of_triangle).collect());
        }
        if self.frustums.is_empty() {
            return Ok(vec![self.unseen; mesh.triangles.len()]);
        }
        let of_triangle = |t| {
            cancelled(self.observer)?;
            Ok((self.seen * self.largest_magnification(mesh, t).sqrt()).max(self.unseen))
        };
        (0..mesh.triangles.len()).into_par_iter().map(of_triangle).collect()
    }

    /// Largest magnification of any point of a triangle, summed over the shots; 0 where hidden.
    fn largest_magnification(&self, mesh: &Mesh, triangle: usize) -> f32 {
        let [a, b, c] = mesh.corners(triangle);
        let normal = mesh.area_vector(triangle).normalize_or_zero();
        let places = (area_of(mesh, triangle) / (self.unit * self.unit)).clamp(*PLACES.start(), *PLACES.end());
        let at = |i: u32| {
            let [u, v] = on_triangle(i);
            let place = a + (b - a) * u + (c - a) * v;
            self.frustums.iter().map(|frustum| self.magnification(frustum, place, normal)).sum()
        };
        (0..places as u32).map(at).fold(0.0, f32::max)
    }

    fn magnification(&self, frustum: &Frustum, place: Vec3, normal: Vec3) -> f32 {
        let magnification = frustum.magnification(place, normal);
        let hidden = || self.scene.occluded_between(frustum.eye, place + (frustum.eye - place) * GAP_AT_END);
        if magnification > 0.0 && !hidden() { magnification } else { 0.0 }
    }
}

/// Share of a picture covered by surfaces.
fn filled_part(shot: &Shot, scene: &Intersector) -> f32 {
    let size = [((ROWS as f32 * shot.aspect).ceil() as u32).clamp(1, 64 * ROWS), ROWS];
    let projection = shot.camera.projection(size);
    let hits = |pixel: u32| {
        let center = Vec2::new((pixel % size[0]) as f32 + 0.5, (pixel / size[0]) as f32 + 0.5);
        let (origin, direction) = projection.ray(center);
        scene.occluded(origin, direction)
    };
    let rays = size[0] * size[1];
    (0..rays).into_par_iter().filter(|&pixel| hits(pixel)).count() as f32 / rays as f32
}

/// Edge length of equal triangles that fill `area`, twice as many as vertices.
fn edge_length(area: f32, vertices: f32) -> f32 {
    (1.15 * area / vertices.max(1.0)).sqrt()
}

fn area_of(mesh: &Mesh, triangle: usize) -> f32 {
    0.5 * mesh.area_vector(triangle).length()
}
