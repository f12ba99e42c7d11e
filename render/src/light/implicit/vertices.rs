//! The leaves beside each vertex, on both of its sides.

use super::Sides;
use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    implicit::{Receiver, VertexWeights},
    surfel::disc_forest::DiscForest,
};

/// Weights of leaves at vertices.
pub struct VertexLeaves {
    front: VertexWeights,
    back: VertexWeights,
    /// Whether light is received on both sides.
    is_two_sided: Vec<bool>,
}

impl VertexLeaves {
    /// For the vertices of a dataset, on its forest as baked.
    pub fn new(forest: &DiscForest, dataset: &Dataset) -> Self {
        let mesh = &dataset.scene.mesh;
        let mut object_of = vec![0; mesh.positions.len()];
        let mut is_two_sided = vec![false; mesh.positions.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for &vertex in corners {
                object_of[vertex as usize] = mesh.triangle_object[t];
                is_two_sided[vertex as usize] |= dataset.two_sided[t];
            }
        }
        let weights = |side: f32| {
            let receiver = |(v, &object): (usize, &u32)| Receiver {
                object,
                position: mesh.positions[v],
                normal: mesh.normals[v] * side,
            };
            VertexWeights::new(forest, &object_of.iter().enumerate().map(receiver).collect::<Vec<_>>())
        };
        Self { front: weights(1.0), back: weights(-1.0), is_two_sided }
    }

    /// The leaves beside a vertex, of all sides that receive light, and their weights.
    pub fn of(&self, vertex: u32) -> impl Iterator<Item = (u32, f32)> + Clone {
        let back = if self.is_two_sided[vertex as usize] { self.back.row(vertex as usize) } else { &[] };
        self.front.row(vertex as usize).iter().chain(back).copied()
    }

    /// Values of the vertices from those of the leaves.
    pub fn apply(&self, leaves: &[Vec3]) -> Sides {
        Sides { front: self.front.apply(leaves), back: self.back.apply(leaves) }
    }
}
