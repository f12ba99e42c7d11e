//! Points at which two meshless solutions are compared, to find the pixels that show the difference.

use super::functions::{MeshlessLight, is_back_lit};
use crate::baked::Baked;
use glam::{Mat3A, Vec3};
use lapidary_core::{
    dataset::Dataset,
    meshless::{Basis, Flattening, FunctionPlace, MeshlessBake},
};
use rayon::prelude::*;

/// Points that measure how meshless light changes: the vertices, on both sides where both are lit, and the senders' points, which
/// also lie within large triangles.
pub struct ComparedPoints {
    light: Flattening,
    /// Patches of vertices around each point, one bit each; the pixels there show its light.
    patches: Vec<u64>,
}

impl ComparedPoints {
    /// `None` without a basis.
    pub fn new(baked: &Baked) -> Option<Self> {
        let dataset = &baked.dataset;
        let MeshlessBake { basis, transport } = dataset.meshless.as_deref()?;
        let (mesh, patches) = (&dataset.scene.mesh, baked.patches());
        let of_vertices = |vertices: &[u32]| vertices.iter().fold(0, |bits, &v| bits | 1 << patches[v as usize]);
        let fronts = (0..).zip(mesh.positions.iter().copied().zip(mesh.normals.iter().copied()));
        let backs = lit_backs(dataset, basis);
        let vertices = fronts.chain(backs).map(|(vertex, point)| (point, of_vertices(&[vertex])));
        let senders = basis.sender_points().iter().map(|sender| {
            let triangle = mesh.triangles[sender.place.triangle as usize];
            ((sender.position, sender.normal), of_vertices(&triangle))
        });
        let (points, patches): (Vec<_>, Vec<_>) = vertices.chain(senders).unzip();
        Some(Self { light: Flattening::new(basis, transport, &points), patches })
    }

    /// Changes from one light to another at each point, as `share` computes them, and the patches of vertices there.
    pub fn changes(
        &self,
        old: &MeshlessLight,
        new: &MeshlessLight,
        share: fn(Vec3, Vec3) -> f32,
    ) -> (Vec<f32>, Vec<u64>) {
        let [old, new] = [old, new].map(|light| self.light.apply(light.coefficients()));
        let change = |(old, new): (&Mat3A, &Mat3A)| share(lengths(*new - *old), lengths(*new));
        (old.par_iter().zip(&new).map(change).collect(), self.patches.clone())
    }
}

/// Vertices of two-sided triangles whose back is lit, with position and normal.
fn lit_backs(dataset: &Dataset, basis: &Basis) -> Vec<(u32, (Vec3, Vec3))> {
    let mesh = &dataset.scene.mesh;
    let mut seen_from_both = vec![false; mesh.positions.len()];
    let two_sided = mesh.triangles.iter().zip(&dataset.two_sided).filter(|(_, two_sided)| **two_sided);
    two_sided.flat_map(|(triangle, _)| triangle).for_each(|&vertex| seen_from_both[vertex as usize] = true);
    let back = |vertex: u32| (vertex, (mesh.positions[vertex as usize], -mesh.normals[vertex as usize]));
    let vertices = (0..seen_from_both.len() as u32).into_par_iter().filter(|&v| seen_from_both[v as usize]);
    vertices
        .map(back)
        .filter(|(_, (position, normal))| is_back_lit(basis.functions(), &FunctionPlace::new(*position, *normal)))
        .collect()
}

fn lengths(vector: Mat3A) -> Vec3 {
    Vec3::new(vector.x_axis.length(), vector.y_axis.length(), vector.z_axis.length())
}
