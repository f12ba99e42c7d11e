//! Binds the vertices of an object to the surface of its file.
//!
//! Each vertex is bound to the nearest point of the object at rest, and moves with it. Its normal and its tangent turn
//! with a frame at that point: the interpolated corner normal, and the longest edge of the triangle projected across
//! it. The frame turns smoothly between the corners; the differential of each triangle alone would jump at its edges.
//! Where a corner has no frame, nothing turns.

use super::{
    nearest::{NearestPoint, NearestPoints, blend},
    shape::{Posture, Shape},
    surface::{BATCH, Surface},
};
use crate::{bounds::is_within_reach, mesh::Mesh, scene::pose::PosedVertices};
use glam::{Mat3, Vec3, Vec4};
use rayon::prelude::*;

/// A movable object.
#[derive(Debug)]
pub struct BoundObject {
    /// Its index in the scene.
    pub object: u32,
    /// The object in the world at rest; its shapes in sequence.
    at_rest: Surface,
    vertices: Vec<BoundVertex>,
}

/// A vertex as baked, and its binding.
#[derive(Clone, Copy, Debug)]
struct BoundVertex {
    position: Vec3,
    normal: Vec3,
    tangent: Vec4,
    /// Corners of its triangle, the longest edge first.
    corners: [u32; 3],
    weights: [f32; 3],
    /// Normal and tangent in the frame at rest; `None` without a frame.
    in_frame: Option<[Vec3; 2]>,
}

impl BoundObject {
    /// Binds the `vertices` of an object of the mesh to its shapes. Also returns the distance of the farthest vertex in
    /// meters: infinite if the shapes have no triangles, or if a vertex is not finite.
    pub fn new(object: u32, shapes: &[Shape], at_rest: &Posture, mesh: &Mesh, vertices: &[u32]) -> (Self, f32) {
        let at_rest = posed(shapes, at_rest);
        let triangles = triangles_within_reach(shapes, &at_rest);
        let points = NearestPoints::new(&at_rest, &triangles);
        let bind = |&vertex: &u32| {
            let vertex = vertex as usize;
            let (position, normal, tangent) = (mesh.positions[vertex], mesh.normals[vertex], mesh.tangents[vertex]);
            let nearest = points.find(position, normal)?;
            let (corners, weights) = longest_edge_first(&at_rest, triangles[nearest.triangle], &nearest);
            let mut bound = BoundVertex { position, normal, tangent, corners, weights, in_frame: None };
            let rest_from_world = bound.frame(&at_rest).map(|frame| frame.transpose());
            bound.in_frame = rest_from_world.map(|frame| [frame * normal, frame * tangent.truncate()]);
            Some((bound, nearest.distance))
        };
        let bound: Vec<_> = vertices.par_iter().with_min_len(BATCH).map(bind).collect();
        let distance = |of: &Option<(BoundVertex, f32)>| match of {
            Some((_, distance)) if *distance >= 0.0 => *distance,
            _ => f32::INFINITY,
        };
        let farthest = bound.iter().map(distance).fold(0.0, f32::max);
        let vertices = bound.into_iter().flatten().map(|(vertex, _)| vertex).collect();
        (Self { object, at_rest, vertices }, farthest)
    }

    /// The vertices for a posture of the shapes; `None` if all are as baked, to the bit.
    pub fn posed(&self, shapes: &[Shape], posture: &Posture) -> Option<PosedVertices> {
        let now = posed(shapes, posture);
        if now == self.at_rest {
            return None;
        }
        let shifts = self.at_rest.shifts_to(&now);
        let one = |vertex: &BoundVertex| vertex.posed(&self.at_rest, &now, &shifts);
        let mut posed = PosedVertices::default();
        let vertices: Vec<_> = self.vertices.par_iter().with_min_len(BATCH).map(one).collect();
        for (position, normal, tangent) in vertices {
            posed.positions.push(position);
            posed.normals.push(normal);
            posed.tangents.push(tangent);
        }
        Some(posed)
    }
}

impl BoundVertex {
    /// The vertex on the surface `now`, which is `at_rest` moved by `shifts`.
    fn posed(&self, at_rest: &Surface, now: &Surface, shifts: &[Vec3]) -> (Vec3, Vec3, Vec4) {
        if self.is_same_on(at_rest, now) {
            return (self.position, self.normal, self.tangent);
        }
        let position = self.position + blend(shifts, self.corners, self.weights);
        let turned = self.in_frame.zip(self.frame(now)).map(|(in_frame, frame)| in_frame.map(|at| frame * at));
        let [normal, tangent] = turned.unwrap_or([self.normal, self.tangent.truncate()]);
        (position, normal, tangent.extend(self.tangent.w))
    }

    /// Whether two surfaces agree, to the bit, in everything the vertex depends on: its edge, and the corners with a weight.
    fn is_same_on(&self, a: &Surface, b: &Surface) -> bool {
        let all = self.corners.iter().map(|&corner| corner as usize).zip(self.weights).enumerate();
        let mut parts = all.filter(|(k, (_, weight))| *k < 2 || *weight != 0.0);
        parts.all(|(_, (corner, weight))| {
            a.positions[corner] == b.positions[corner] && (weight == 0.0 || a.normals[corner] == b.normals[corner])
        })
    }

    /// Columns are the edge across the normal, the direction across both, and the normal of a surface at the binding.
    fn frame(&self, surface: &Surface) -> Option<Mat3> {
        let normal = blend(&surface.normals, self.corners, self.weights).try_normalize()?;
        let [from, to] = [self.corners[0], self.corners[1]].map(|corner| surface.positions[corner as usize]);
        let edge = (to - from).reject_from_normalized(normal).try_normalize()?;
        Some(Mat3::from_cols(edge, normal.cross(edge), normal))
    }
}

impl Surface {
    /// Displacement of each vertex to another surface.
    pub fn shifts_to(&self, other: &Self) -> Vec<Vec3> {
        self.positions.iter().zip(&other.positions).map(|(before, now)| *now - *before).collect()
    }
}

/// The vertices of shapes in a posture, one shape after another.
pub fn posed(shapes: &[Shape], posture: &Posture) -> Surface {
    let mut all = Surface::default();
    for surface in shapes.iter().map(|shape| shape.posed(posture)) {
        all.positions.extend(surface.positions);
        all.normals.extend(surface.normals);
    }
    all
}

/// The triangles of shapes, in [`posed`]'s order of vertices. Triangles out of reach are left out: no scene or box
/// hierarchy contains them.
pub fn triangles_within_reach(shapes: &[Shape], surface: &Surface) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    let mut base = 0;
    for shape in shapes {
        all.extend(shape.triangles.iter().map(|corners| corners.map(|corner| base + corner)));
        base += shape.surface.positions.len() as u32;
    }
    all.retain(|corners| corners.iter().all(|&corner| is_within_reach(surface.positions[corner as usize])));
    all
}

/// The corners of a triangle and their weights, rotated so that the longest edge is between the first two.
fn longest_edge_first(surface: &Surface, corners: [u32; 3], at: &NearestPoint) -> ([u32; 3], [f32; 3]) {
    let place = |k: usize| surface.positions[corners[k % 3] as usize];
    let length_sq = |k: &usize| place(*k).distance_squared(place(k + 1));
    let first = (0..3).max_by(|a, b| length_sq(a).total_cmp(&length_sq(b))).unwrap_or(0);
    ([0, 1, 2].map(|k| corners[(first + k) % 3]), [0, 1, 2].map(|k| at.weights[(first + k) % 3]))
}
