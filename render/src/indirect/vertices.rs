//! The meshless solution at the vertices of a mesh, for display: on the side of their normals, and on the other where
//! light reaches it.
//!
//! Normals of open shells often point away from where they are seen: walls of a room to the outside, leaves and cloth to
//! one side. A function belongs to one side of a surface (meshless paper, 2.1: its distance counts normals), so that
//! each side has a value of its own.

use glam::{Mat3A, Vec3};
use lapidary_core::{
    meshless::{Flattening, MeshlessBake},
    scene::Mesh,
    surfel::Surfel,
};
use rayon::prelude::*;

/// Vector irradiance of bounced light in W/m², a column a colour channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexIrradiance {
    /// On the front of surfaces, whence their triangles are counter-clockwise: one a vertex.
    pub front: Vec<Mat3A>,
    /// On their back: likewise, or empty if no light reaches one.
    pub back: Vec<Mat3A>,
}

impl VertexIrradiance {
    /// Of a vertex whose surface is seen from one side.
    #[inline(always)]
    pub fn at(&self, vertex: u32, from_behind: bool) -> Mat3A {
        let side = if from_behind { &self.back } else { &self.front };
        side.get(vertex as usize).copied().unwrap_or(Mat3A::ZERO)
    }
}

/// Weights of the functions at both sides of the vertices.
#[derive(Clone, Debug)]
pub(super) struct VertexFlattening {
    front: Flattening,
    /// Vertices whose back is lit, and its weights.
    lit_backs: Vec<u32>,
    back: Flattening,
}

impl VertexFlattening {
    pub fn new(bake: &MeshlessBake, mesh: &Mesh) -> Self {
        let lit_backs = lit_backs(bake, mesh);
        let flattening = |points: &[(Vec3, Vec3)]| Flattening::new(&bake.basis, &bake.transport, points);
        let fronts: Vec<_> = mesh.positions.iter().copied().zip(mesh.normals.iter().copied()).collect();
        let backs: Vec<_> = lit_backs.iter().map(|&v| back_of(mesh, v as usize)).collect();
        Self { front: flattening(&fronts), back: flattening(&backs), lit_backs }
    }

    /// The function with these coefficients.
    pub fn apply(&self, coefficients: &[Mat3A]) -> VertexIrradiance {
        let front = self.front.apply(coefficients);
        let mut back = vec![Mat3A::ZERO; if self.lit_backs.is_empty() { 0 } else { front.len() }];
        let of_lit = self.back.apply(coefficients);
        self.lit_backs.iter().zip(of_lit).for_each(|(&vertex, vector)| back[vertex as usize] = vector);
        VertexIrradiance { front, back }
    }
}

/// Vertices whose back is near a function that lies on the back of its surface. Functions on the front of another one close
/// behind, as on the far side of a wall, reach backs too that nobody sees.
fn lit_backs(bake: &MeshlessBake, mesh: &Mesh) -> Vec<u32> {
    let basis = &bake.basis;
    let behind = |point: &Surfel| point.normal.dot(mesh.area_vector(point.place.triangle as usize)) < 0.0;
    let behind: Vec<bool> = basis.points().iter().map(behind).collect();
    if !behind.contains(&true) {
        return Vec::new();
    }
    let is_lit = |values: &mut Vec<(u32, f32)>, vertex: usize| {
        let (position, normal) = back_of(mesh, vertex);
        values.clear();
        (0..basis.levels()).for_each(|level| basis.values(level, position, normal, values));
        values.iter().any(|&(function, _)| behind[function as usize]).then_some(vertex as u32)
    };
    (0..mesh.positions.len()).into_par_iter().map_init(Vec::new, is_lit).flatten().collect()
}

fn back_of(mesh: &Mesh, vertex: usize) -> (Vec3, Vec3) {
    (mesh.positions[vertex], -mesh.normals[vertex])
}
