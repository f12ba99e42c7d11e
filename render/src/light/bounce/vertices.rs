//! The meshless solution at the vertices of a mesh, for display: on the side of their normals, and on the other where
//! it receives light.
//!
//! Normals of open shells often point away from their visible side: walls of a room to the outside, leaves and cloth to
//! one side. A function has no weight at points that face away from it (meshless paper, 2.2, Eq. 8), so each side has
//! its own value.

use glam::{Mat3A, Vec3};
use lapidary_core::{
    dataset::Dataset,
    meshless::{Basis, Flattening, MeshlessBake},
    scene::Mesh,
};
use rayon::prelude::*;

/// Vector irradiance of bounced light in W/m², one column per colour channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexIrradiance {
    /// On the front of surfaces, where their triangles are counter-clockwise: one per vertex.
    pub front: Vec<Mat3A>,
    /// On their back: one per vertex, or empty if no back receives light.
    pub back: Vec<Mat3A>,
}

impl VertexIrradiance {
    /// Irradiance at a vertex for the visible side of its surface.
    #[inline(always)]
    pub fn at(&self, vertex: u32, from_behind: bool) -> Mat3A {
        let vertex = vertex as usize;
        if from_behind { self.back.get(vertex).copied().unwrap_or(Mat3A::ZERO) } else { self.front[vertex] }
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
    pub fn new(dataset: &Dataset, bake: &MeshlessBake) -> Self {
        let mesh = &dataset.scene.mesh;
        let lit_backs = lit_backs(dataset, &bake.basis);
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

/// Vertices of two-sided triangles whose back receives light at any corner: a function of the finest level reaches it.
/// A visible back has such a function close to it. Coarser functions also reach hidden backs, through walls.
fn lit_backs(dataset: &Dataset, basis: &Basis) -> Vec<u32> {
    let mesh = &dataset.scene.mesh;
    let two_sided =
        || mesh.triangles.iter().zip(&dataset.two_sided).filter(|(_, two_sided)| **two_sided).map(|(t, _)| t);
    let mut seen_from_both = vec![false; mesh.positions.len()];
    two_sided().flatten().for_each(|&vertex| seen_from_both[vertex as usize] = true);
    let finest = basis.levels() - 1;
    let is_reached = |values: &mut Vec<(u32, f32)>, (vertex, &both): (usize, &bool)| {
        let (position, normal) = back_of(mesh, vertex);
        values.clear();
        if both {
            basis.values(finest, position, normal, values);
        }
        !values.is_empty()
    };
    let reached: Vec<bool> = seen_from_both.par_iter().enumerate().map_init(Vec::new, is_reached).collect();
    let mut lit = vec![false; reached.len()];
    for triangle in two_sided().filter(|triangle| triangle.iter().any(|&v| reached[v as usize])) {
        triangle.iter().for_each(|&v| lit[v as usize] = true);
    }
    (0..lit.len() as u32).filter(|&v| lit[v as usize]).collect()
}

fn back_of(mesh: &Mesh, vertex: usize) -> (Vec3, Vec3) {
    (mesh.positions[vertex], -mesh.normals[vertex])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes;
    use lapidary_core::{brdf::GgxParameters, meshless::Transport, surfel::Surfel};

    /// A floor of 4 x 4 m whose back alone is lit near one corner, from a sender far away; all triangles are two-sided.
    fn dataset() -> Dataset {
        let mut dataset = test_scenes::dataset(test_scenes::mesh(8, false), GgxParameters::default());
        dataset.two_sided.fill(true);
        let at = |position: Vec3, normal: Vec3| Surfel { position, normal, ..Default::default() };
        let corner = Vec3::new(2.0, 0.0, 2.0);
        let coarse = vec![at(Vec3::Y * 50.0, Vec3::NEG_Y), at(Vec3::ZERO, Vec3::NEG_Y)];
        let fine = vec![at(corner, Vec3::NEG_Y), at(corner - Vec3::X, Vec3::NEG_Y)];
        let basis = Basis::new(&[coarse, fine], 1.0, 1).unwrap();
        let link = |y: f32| vec![(0, Vec3::new(0.1, y, 0.0))];
        let transport = Transport::from_rows(&[Vec::new(), link(-0.9), link(-0.5), link(-0.2)], 2);
        dataset.meshless = Some(MeshlessBake { basis, transport });
        dataset
    }

    #[test]
    fn backs_have_the_solution_on_their_side_where_a_fine_function_reaches_them() {
        let dataset = dataset();
        let (bake, mesh) = (dataset.meshless.as_ref().unwrap(), &dataset.scene.mesh);
        let coefficients: Vec<Mat3A> = (0..4).map(|i| Mat3A::IDENTITY * (1.0 + i as f32)).collect();
        let found = VertexFlattening::new(&dataset, bake).apply(&coefficients);
        let lit: Vec<usize> = (0..mesh.positions.len()).filter(|&v| found.back[v] != Mat3A::ZERO).collect();
        // The first three vertices of the grid are at the other corner.
        assert!(lit.len() > 4 && lit.len() < mesh.positions.len() / 2 && lit[0] > 2, "{lit:?}");
        let mut linked = coefficients.clone();
        linked[0] = Mat3A::ZERO;
        for &v in &lit {
            let expected = bake.basis.evaluate(2, mesh.positions[v], Vec3::NEG_Y, &linked);
            assert!(found.back[v].abs_diff_eq(expected, 1e-4), "{v}");
        }
        assert!(lit.iter().any(|&v| found.back[v] != found.back[lit[0]]), "not all the same");
        let first = lit[0] as u32;
        assert!(found.at(first, true) == found.back[lit[0]] && found.at(first, false) == Mat3A::ZERO);
        assert!(found.front.iter().all(|v| *v == Mat3A::ZERO), "negative control: no function is in front");
    }

    #[test]
    fn one_sided_surfaces_and_what_only_coarse_functions_reach_have_no_backs() {
        let lit = |change: &dyn Fn(&mut Dataset)| {
            let mut dataset = dataset();
            change(&mut dataset);
            lit_backs(&dataset, &dataset.meshless.as_ref().unwrap().basis).len()
        };
        assert!(lit(&|_| {}) > 0, "negative control");
        assert_eq!(lit(&|d| d.two_sided.fill(false)), 0);
        let far = |d: &mut Dataset| d.scene.mesh.positions.iter_mut().for_each(|p| *p -= Vec3::new(2.0, 0.0, 2.0));
        assert_eq!(lit(&far), 0, "under the coarse function alone");
    }
}
