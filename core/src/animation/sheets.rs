//! Sheets of one object that coincide at rest and move apart. A vertex of the bake could be bound to either, and
//! nothing determines which.
//!
//! A trial finds them: each joint and morph target changes in its own way, and triangles that meet must then move together.

use super::{
    binding::{posed, triangles_within_reach},
    nearest::{NearestPoint, NearestPoints, blend},
    shape::{Posture, Shape},
    surface::BATCH,
};
use crate::bounds::{Bounds, is_within_reach};
use glam::Vec3;
use rayon::prelude::*;

/// Distance by which the trial moves joints, relative to the diagonal of an object.
const TRIAL: f32 = 1e-2;

/// Largest distance between points that meet after the trial, relative to the diagonal: a tenth of the distance of two joints.
const MOST_APART: f32 = 1e-3;

/// Whether triangles of an object meet at rest with the same orientation, and move apart.
pub fn meet_and_part(shapes: &[Shape], at_rest: &Posture) -> bool {
    let is_deformed = |shape: &Shape| shape.deformation.skin.is_some() || !shape.deformation.targets.is_empty();
    if !shapes.iter().any(is_deformed) {
        return false;
    }
    let surface = posed(shapes, at_rest);
    let triangles = triangles_within_reach(shapes, &surface);
    let diagonal =
        Bounds::around(triangles.iter().flatten().map(|&vertex| surface.positions[vertex as usize])).diagonal();
    let shifts = surface.shifts_to(&posed(shapes, &at_rest.trial(TRIAL * diagonal)));
    let points = NearestPoints::new(&surface, &triangles);
    let shift = |point: &NearestPoint| blend(&shifts, triangles[point.triangle], point.weights);
    let parts = |(place, normal): (&Vec3, &Vec3)| {
        let shifts: Vec<Vec3> = points.meeting(*place, *normal).iter().map(shift).collect();
        shifts.iter().any(|shift| !(shift.distance(shifts[0]) <= MOST_APART * diagonal))
    };
    let vertices = surface.positions.par_iter().zip(&surface.normals).with_min_len(BATCH);
    vertices.filter(|(place, _)| is_within_reach(**place)).any(parts)
}
