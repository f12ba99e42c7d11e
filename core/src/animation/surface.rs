//! Vertices of a mesh, transformed into the world: changed by morph targets, then placed by a node or a skin (glTF 2.0,
//! sections 3.7.2.2 and 3.7.3).

use super::skin::Influences;
use glam::{Mat3, Mat4, Vec3, Vec4};
use rayon::prelude::*;

/// Smallest number of vertices worth a thread.
pub const BATCH: usize = 1024;

/// Vertices. All arrays have equal length, except that tangents may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Positions in meters.
    pub positions: Vec<Vec3>,
    /// Unit normals; zero where the file has none.
    pub normals: Vec<Vec3>,
    /// Directions of +u with the handedness of their frames; zero where the file has none.
    pub tangents: Vec<Vec4>,
}

/// Offsets that a morph target adds to vertices. Arrays missing in the file are empty.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// Offsets of positions.
    pub positions: Vec<Vec3>,
    /// Offsets of normals.
    pub normals: Vec<Vec3>,
    /// Offsets of tangents.
    pub tangents: Vec<Vec3>,
}

impl Surface {
    /// Adds morph targets by their weights. Targets of weight 0 change no bit.
    pub fn morph(&mut self, targets: &[MorphTarget], weights: &[f32]) {
        for (target, &weight) in targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            self.positions.iter_mut().zip(&target.positions).for_each(|(p, d)| *p += weight * d);
            self.normals.iter_mut().zip(&target.normals).for_each(|(n, d)| *n += weight * d);
            self.tangents.iter_mut().zip(&target.tangents).for_each(|(t, d)| *t += (weight * d).extend(0.0));
        }
    }

    /// Transforms the surface by a node's matrix. Returns whether that mirrors it, so that its triangles must be reversed.
    pub fn place(&mut self, world_from_node: Mat4) -> bool {
        let placing = Placing::new(world_from_node);
        self.place_each(|_| placing);
        placing.is_mirrored()
    }

    /// Transforms the surface by the joints of a skin, each vertex by the mean of their matrices. Returns whether that
    /// mirrors most vertices.
    pub fn skin(&mut self, influences: &Influences, world_from_mesh: &[Mat4]) -> bool {
        let mirrored = self.place_each(|vertex| Placing::new(influences.mean(vertex, world_from_mesh)));
        2 * mirrored > self.positions.len()
    }

    /// Transforms each vertex. Returns the number of mirrored ones.
    fn place_each(&mut self, placing: impl Fn(usize) -> Placing + Sync) -> usize {
        let Self { positions, normals, tangents } = self;
        tangents.iter_mut().enumerate().for_each(|(vertex, tangent)| *tangent = placing(vertex).tangent(*tangent));
        let vertices = positions.par_iter_mut().zip(normals).enumerate().with_min_len(BATCH);
        let place = |(vertex, (position, normal)): (usize, (&mut Vec3, &mut Vec3))| {
            let placing = placing(vertex);
            *position = placing.matrix.transform_point3(*position);
            *normal = (placing.normals * *normal).normalize_or_zero();
            usize::from(placing.is_mirrored())
        };
        vertices.map(place).sum()
    }

    /// Sets missing normals to the area-weighted mean of the adjacent triangles' normals.
    pub fn complete_normals(&mut self, triangles: &[[u32; 3]]) {
        let is_missing: Vec<bool> = self.normals.iter().map(|normal| *normal == Vec3::ZERO).collect();
        for corners in triangles.iter().filter(|corners| corners.iter().any(|&c| is_missing[c as usize])) {
            let [a, b, c] = corners.map(|c| self.positions[c as usize]);
            let area = (b - a).cross(c - a);
            let missing = corners.iter().map(|&c| c as usize).filter(|&c| is_missing[c]);
            missing.for_each(|corner| self.normals[corner] += area);
        }
        let filled = self.normals.iter_mut().zip(is_missing).filter(|(_, is_missing)| *is_missing);
        filled.for_each(|(normal, _)| *normal = normal.normalize_or_zero());
    }
}

/// A matrix, and its effect on normals.
#[derive(Clone, Copy)]
struct Placing {
    matrix: Mat4,
    linear: Mat3,
    normals: Mat3,
    handedness: f32,
}

impl Placing {
    fn new(matrix: Mat4) -> Self {
        let linear = Mat3::from_mat4(matrix);
        let handedness = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        Self { matrix, linear, normals: handedness * cofactors(linear), handedness }
    }

    fn is_mirrored(&self) -> bool {
        self.handedness < 0.0
    }

    fn tangent(&self, tangent: Vec4) -> Vec4 {
        (self.linear * tangent.truncate()).extend(self.handedness * tangent.w)
    }
}

/// The inverse transpose times the determinant, which exists for every matrix.
fn cofactors(m: Mat3) -> Mat3 {
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}
