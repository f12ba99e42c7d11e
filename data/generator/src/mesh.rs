//! Triangle meshes, the only type of pieces.
//!
//! Front faces wind counter-clockwise seen from outside. Positions are meters, Y up.

use std::collections::HashMap;

use glam::{Affine3A, Vec2, Vec3};

/// An indexed triangle mesh with a normal and a texture coordinate at every vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions in meters.
    pub positions: Vec<Vec3>,
    /// Unit normals, outward.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, origin at the top left of the image as in glTF.
    pub uvs: Vec<Vec2>,
    /// Three per triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Adds a vertex and returns its index.
    pub fn push(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle.
    pub fn triangle(&mut self, a: u32, b: u32, c: u32) {
        self.indices.extend([a, b, c]);
    }

    /// Adds a quad given counter-clockwise, cut along the diagonal from its first corner.
    pub fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Appends a copy of `other`.
    pub fn append(&mut self, other: &Mesh) {
        let base = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.uvs.extend(&other.uvs);
        self.indices.extend(other.indices.iter().map(|i| i + base));
    }

    /// The mesh moved by a rigid transform (rotation and translation, no scale).
    pub fn moved(mut self, world_from_object: Affine3A) -> Mesh {
        for p in &mut self.positions {
            *p = world_from_object.transform_point3(*p);
        }
        for n in &mut self.normals {
            *n = world_from_object.transform_vector3(*n).normalize();
        }
        self
    }

    /// The mesh shifted by `offset` meters.
    pub fn shifted(self, offset: Vec3) -> Mesh {
        self.moved(Affine3A::from_translation(offset))
    }

    /// The mesh lifted or lowered until its lowest point lies at `y = 0`.
    pub fn grounded(self) -> Mesh {
        let lowest = self.lowest();
        self.shifted(Vec3::Y * -lowest)
    }

    /// Height of the lowest vertex.
    pub fn lowest(&self) -> f32 {
        self.positions.iter().fold(f32::INFINITY, |low, p| low.min(p.y))
    }

    /// The mesh with texture coordinates multiplied by `tiles`.
    pub fn tiled(mut self, tiles: Vec2) -> Mesh {
        for uv in &mut self.uvs {
            *uv *= tiles;
        }
        self
    }

    /// Corners of triangle `t`.
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        [0, 1, 2].map(|k| self.positions[self.indices[3 * t + k] as usize])
    }

    /// The mesh without the triangles whose three normals are `normal`, and without the vertices that only they use.
    pub fn without_flat(&self, normal: Vec3) -> Mesh {
        let mut rest = Mesh::default();
        let mut renamed = HashMap::new();
        for triangle in self.indices.chunks_exact(3) {
            if triangle.iter().all(|&v| self.normals[v as usize] == normal) {
                continue;
            }
            for &v in triangle {
                let i = v as usize;
                let push = || rest.push(self.positions[i], self.normals[i], self.uvs[i]);
                let new = *renamed.entry(v).or_insert_with(push);
                rest.indices.push(new);
            }
        }
        rest
    }

    /// Replaces the normals by area-weighted means over all triangles that share a position, so that texture seams do
    /// not show in the shading.
    pub fn smooth_normals(&mut self) {
        let mut sums: HashMap<[u32; 3], Vec3> = HashMap::new();
        for t in 0..self.triangle_count() {
            let [a, b, c] = self.corners(t);
            let area_normal = (b - a).cross(c - a);
            for p in [a, b, c] {
                *sums.entry(position_key(p)).or_default() += area_normal;
            }
        }
        for (p, n) in self.positions.iter().zip(&mut self.normals) {
            *n = sums[&position_key(*p)].normalize_or(Vec3::Y);
        }
    }
}

/// Bits of a position, so that vertices split by a texture seam count as one.
pub fn position_key(p: Vec3) -> [u32; 3] {
    // Adding zero turns -0.0 into +0.0: both are the same place.
    [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f32::to_bits)
}

#[cfg(test)]
pub mod checks {
    //! Conditions for every mesh of the bundle.

    use super::*;

    /// Finite, unit normals, indices in range, no degenerate triangle, normals on the front side.
    pub fn assert_sound(mesh: &Mesh) {
        let count = mesh.positions.len();
        assert!(mesh.triangle_count() > 0, "no triangles");
        assert!(mesh.normals.len() == count && mesh.uvs.len() == count);
        assert!(mesh.indices.iter().all(|i| (*i as usize) < count));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3));
        for t in 0..mesh.triangle_count() {
            assert_sound_triangle(mesh, t);
        }
    }

    fn assert_sound_triangle(mesh: &Mesh, t: usize) {
        let [a, b, c] = mesh.corners(t);
        let area_normal = (b - a).cross(c - a);
        // A square of 10 micrometers: far below any intended triangle, far above rounding.
        assert!(area_normal.length() > 1e-10, "degenerate triangle {t}: {a} {b} {c}");
        for k in 0..3 {
            let n = mesh.normals[mesh.indices[3 * t + k] as usize];
            assert!(n.dot(area_normal.normalize()) > 0.0, "normal behind triangle {t}: {a} {b} {c} {n}");
        }
    }

    /// Every edge is used once in each direction, and the enclosed volume is positive.
    pub fn assert_closed(mesh: &Mesh) {
        let mut uses: HashMap<([u32; 3], [u32; 3]), i32> = HashMap::new();
        for t in 0..mesh.triangle_count() {
            let [a, b, c] = mesh.corners(t).map(position_key);
            for edge in [(a, b), (b, c), (c, a)] {
                *uses.entry(edge).or_default() += 1;
            }
        }
        for ((a, b), count) in &uses {
            let at = a.map(f32::from_bits);
            assert_eq!(*count, 1, "edge used twice in one direction at {at:?}");
            assert!(uses.contains_key(&(*b, *a)), "open edge at {at:?}");
        }
        assert!(volume(mesh) > 0.0, "inside out");
    }

    /// Enclosed volume in cubic meters, negative when the faces point inward.
    pub fn volume(mesh: &Mesh) -> f32 {
        let volumes = (0..mesh.triangle_count()).map(|t| {
            let [a, b, c] = mesh.corners(t);
            a.dot(b.cross(c)) / 6.0
        });
        volumes.sum()
    }

    #[test]
    #[should_panic(expected = "open edge")]
    fn a_missing_triangle_is_noticed() {
        let mut mesh = crate::gem::brilliant(0.1);
        mesh.indices.truncate(mesh.indices.len() - 3);
        assert_closed(&mesh);
    }

    #[test]
    #[should_panic(expected = "inside out")]
    fn inverted_faces_are_noticed() {
        let mut mesh = crate::gem::brilliant(0.1);
        mesh.indices.reverse();
        assert_closed(&mesh);
    }
}
