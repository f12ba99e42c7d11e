//! Rebuilds missing normals as the mean of the face normals around a position, weighted by the angle of each face's
//! corner. A position keeps more than one normal only where edges sharper than [`CREASE_COSINE`] separate the faces
//! around it into fans: a single sharp edge, frequent in noisy scans, splits nothing. (On a scan of 100,250 vertices
//! this adds 6 %, where its surface folds back on itself; joining the fans with similar mean normals lowered that only
//! to 5.9 %, and rounded off chamfers elsewhere.) A file can say instead which faces are smooth; see [`Smoothing`].

use super::{RawMesh, bits};
use glam::Vec3;
use std::collections::HashMap;

/// Cosine of the crease angle: faces that meet at more than 60 degrees do not share a rebuilt normal. A hexagonal prism
/// stays smooth, and a cube does not.
const CREASE_COSINE: f32 = 0.499;

/// Largest number of faces on an edge that each face is compared with: thousands on one edge would take forever.
const MOST_NEIGHBOURS: usize = 16;

/// How the normals of a triangle are rebuilt where it has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::import) enum Smoothing {
    /// Smooth across edges that are not sharp.
    ByAngle,
    /// The normal of the face of this number, which may be several triangles.
    Flat(u32),
    /// Smooth with the triangles of this group, whatever their angle, and with no others.
    Group(u32),
}

/// The rebuilt normal of every corner of every triangle; see the top of the file.
pub(super) fn smooth_normals(raw: &RawMesh) -> Vec<[Vec3; 3]> {
    let position_ids = position_ids(raw);
    let faces: Vec<Vec3> = (0..raw.triangles.len()).map(|t| raw.face_normal(t)).collect();
    let mut fans = Fans::new(3 * raw.triangles.len());
    join_by_angle(raw, &position_ids, &faces, &mut fans);
    join_by_file(raw, &position_ids, &mut fans);
    let mut sums = vec![Vec3::ZERO; 3 * raw.triangles.len()];
    for (t, face) in faces.iter().enumerate() {
        for (k, angle) in corner_angles(raw.corners(t)).into_iter().enumerate() {
            sums[fans.find(3 * t + k)] += angle * *face;
        }
    }
    let normal = |t: usize, k: usize, fans: &mut Fans| sums[fans.find(3 * t + k)].normalize_or(faces[t]);
    (0..raw.triangles.len()).map(|t| [0, 1, 2].map(|k| normal(t, k, &mut fans))).collect()
}

fn corner_angles([a, b, c]: [Vec3; 3]) -> [f32; 3] {
    let at = |p: Vec3, q: Vec3, r: Vec3| (q - p).angle_between(r - p);
    [at(a, b, c), at(b, c, a), at(c, a, b)].map(|angle| if angle.is_finite() { angle } else { 0.0 })
}

/// A number for each distinct position within an object, per vertex; 0 if no triangle uses the vertex.
fn position_ids(raw: &RawMesh) -> Vec<u32> {
    let mut ids = vec![0; raw.positions.len()];
    let mut known = HashMap::new();
    for (corners, &object) in raw.triangles.iter().zip(&raw.triangle_object) {
        for &v in corners {
            let next = known.len() as u32;
            let key = (object, bits(raw.positions[v as usize].to_array()));
            ids[v as usize] = *known.entry(key).or_insert(next);
        }
    }
    ids
}

/// Joins the corners of faces that share a smooth edge, where the file leaves that to the angle.
fn join_by_angle(raw: &RawMesh, position_ids: &[u32], faces: &[Vec3], fans: &mut Fans) {
    let by_angle = |t: usize| raw.triangle_smoothing.get(t).is_none_or(|&smoothing| smoothing == Smoothing::ByAngle);
    let mut edges = Vec::with_capacity(3 * raw.triangles.len());
    for (t, corners) in raw.triangles.iter().enumerate().filter(|(t, _)| by_angle(*t)) {
        let ids = corners.map(|v| position_ids[v as usize]);
        for k in 0..3 {
            let (a, b) = ((ids[k], 3 * t + k), (ids[(k + 1) % 3], 3 * t + (k + 1) % 3));
            let ((low, corner_low), (high, corner_high)) = if a.0 < b.0 { (a, b) } else { (b, a) };
            edges.push((low, high, corner_low as u32, corner_high as u32));
        }
    }
    edges.sort_unstable();
    for shared in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        join_across_edge(shared, faces, fans);
    }
}

/// Joins the corners that the file says are smooth: of a group at a position, and all of a flat face.
fn join_by_file(raw: &RawMesh, position_ids: &[u32], fans: &mut Fans) {
    let mut corners = Vec::new();
    for (t, (triangle, &smoothing)) in raw.triangles.iter().zip(&raw.triangle_smoothing).enumerate() {
        for (k, &v) in triangle.iter().enumerate() {
            match smoothing {
                Smoothing::ByAngle => {}
                Smoothing::Flat(_) => corners.push((smoothing, 0, 3 * t + k)),
                Smoothing::Group(_) => corners.push((smoothing, position_ids[v as usize], 3 * t + k)),
            }
        }
    }
    corners.sort_unstable();
    for pair in corners.windows(2).filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1)) {
        fans.join(pair[0].2, pair[1].2);
    }
}

/// An edge as two position numbers, and the corners of one of its faces there.
type Edge = (u32, u32, u32, u32);

fn join_across_edge(shared: &[Edge], faces: &[Vec3], fans: &mut Fans) {
    for (i, a) in shared.iter().enumerate() {
        for b in shared[i + 1..].iter().take(MOST_NEIGHBOURS) {
            if faces[a.2 as usize / 3].dot(faces[b.2 as usize / 3]) > CREASE_COSINE {
                fans.join(a.2 as usize, b.2 as usize);
                fans.join(a.3 as usize, b.3 as usize);
            }
        }
    }
}

/// Disjoint sets of corners.
struct Fans {
    parent: Vec<u32>,
}

impl Fans {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    fn find(&mut self, mut corner: usize) -> usize {
        while self.parent[corner] as usize != corner {
            self.parent[corner] = self.parent[self.parent[corner] as usize];
            corner = self.parent[corner] as usize;
        }
        corner
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b)] = a.min(b) as u32;
    }
}
