//! The edge of a mesh under the pointer, on which a pivot can be placed.

use super::{handles::distance_to_segment, projection::Projection};
use egui::{Pos2, Rect};
use glam::Vec3;
use lapidary_core::scene::Mesh;
use std::collections::HashMap;

/// Largest distance of the pointer from an edge, in points.
const REACH: f32 = 12.0;
/// Cosine of the smallest angle between the sides of an edge: 25 degrees, so that the facets of round things have none.
const SMOOTH: f32 = 0.906;
/// Depth behind the surface under the pointer at which an edge counts as hidden, as a share of the surface's depth.
const HIDDEN: f32 = 0.03;

/// The edge nearest to the pointer among those of `is_shown` triangles, as its ends in meters: a line where two sides meet at an
/// angle, or where a surface ends. `depth` is that of the surface under the pointer, which hides edges behind it.
pub fn edge_at(
    mesh: &Mesh,
    projection: &Projection,
    pointer: Pos2,
    depth: Option<f32>,
    is_shown: impl Fn(usize) -> bool,
) -> Option<[Vec3; 2]> {
    let mut sides: HashMap<[[u32; 3]; 2], Sides> = HashMap::new();
    // Both sides of an edge near the pointer are near it, so that both are found.
    for triangle in (0..mesh.triangles.len()).filter(|&triangle| is_shown(triangle)) {
        let corners = mesh.corners(triangle);
        if !is_near(projection, corners, pointer) {
            continue;
        }
        let Some(normal) = mesh.area_vector(triangle).try_normalize() else { continue };
        for ends in [[corners[0], corners[1]], [corners[1], corners[2]], [corners[2], corners[0]]] {
            let Some([a, b]) = projection.segment(ends[0], ends[1]) else { continue };
            let distance = distance_to_segment(pointer, a, b);
            if distance <= REACH {
                let found = sides.entry(key(ends)).or_insert(Sides { ends, distance, normals: Vec::new() });
                found.normals.push(normal);
            }
        }
    }
    let nearest = |edge: &Sides| edge.ends.map(|end| projection.depth(end)).into_iter().fold(f32::INFINITY, f32::min);
    let is_seen = |edge: &Sides| depth.is_none_or(|depth| nearest(edge) < depth * (1.0 + HIDDEN));
    let seen = sides.into_values().filter(|edge| edge.is_sharp() && is_seen(edge));
    seen.min_by(|a, b| a.distance.total_cmp(&b.distance)).map(|edge| edge.ends)
}

/// Whether the box around a triangle's picture is near the pointer; true where a corner is behind the eye.
fn is_near(projection: &Projection, corners: [Vec3; 3], pointer: Pos2) -> bool {
    let [Some(a), Some(b), Some(c)] = corners.map(|corner| projection.point(corner)) else { return true };
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    Rect::from_min_max(low, high).expand(REACH).contains(pointer)
}

/// The same for the triangles on both sides of an edge, whose vertices may be stored twice.
fn key(ends: [Vec3; 2]) -> [[u32; 3]; 2] {
    // Zero has two signs.
    let mut key = ends.map(|end| (end + Vec3::ZERO).to_array().map(f32::to_bits));
    key.sort_unstable();
    key
}

/// The triangles along an edge.
struct Sides {
    ends: [Vec3; 2],
    /// Distance from the pointer in points.
    distance: f32,
    normals: Vec<Vec3>,
}

impl Sides {
    fn is_sharp(&self) -> bool {
        // A thin sheet has triangles for both of its sides: each side is looked at alone.
        let Some(&first) = self.normals.first() else { return false };
        let side: Vec<Vec3> = self.normals.iter().copied().filter(|normal| normal.dot(first) > 0.0).collect();
        side.len() == 1 || side.iter().any(|normal| normal.dot(first) < SMOOTH)
    }
}
