//! The leaves beside each vertex, on both of its sides.

use crate::device::{GpuForest, LeavesBeside};
use lapidary_core::{
    implicit::{Receiver, VertexWeights, disc_forest::DiscForest},
    mesh::Mesh,
    transport::Coefficient,
};
use std::{ops::Range, sync::OnceLock};

/// Weights of leaves at vertices.
pub struct VertexLeaves {
    front: VertexWeights,
    /// Empty for vertices of one-sided surfaces.
    back: VertexWeights,
    /// The same on a device, from its first use on.
    on_device: OnceLock<LeavesBeside>,
}

impl VertexLeaves {
    /// Weights for the vertices of a mesh on the forest of its surfels. `two_sided` has an entry per triangle.
    pub fn new(forest: &DiscForest, mesh: &Mesh, two_sided: &[bool]) -> Self {
        let mut is_two_sided = vec![false; mesh.positions.len()];
        for (corners, is_sheet) in mesh.triangles.iter().zip(two_sided) {
            corners.iter().for_each(|&vertex| is_two_sided[vertex as usize] |= is_sheet);
        }
        let owners = mesh.owners();
        let receiver = |(v, &object): (usize, &u32), side: f32| Receiver {
            object,
            position: mesh.positions[v],
            normal: mesh.normals[v] * side,
        };
        let all = || owners.iter().enumerate();
        let front: Vec<_> = all().map(|at| Some(receiver(at, 1.0))).collect();
        let back: Vec<_> = all().map(|at| is_two_sided[at.0].then(|| receiver(at, -1.0))).collect();
        let [front, back] = [front, back].map(|receivers| VertexWeights::new(forest, &receivers));
        Self { front, back, on_device: OnceLock::new() }
    }

    /// The leaves beside a vertex on all lit sides, with their weights.
    pub fn of(&self, vertex: u32) -> impl Iterator<Item = (u32, f32)> + Clone {
        [&self.front, &self.back].into_iter().flat_map(move |side| side.row(vertex as usize)).copied()
    }

    /// The same on the device of a forest, which is that of all calls.
    pub fn on_device(&self, forest: &GpuForest) -> &LeavesBeside {
        self.on_device.get_or_init(|| {
            let (mut leaves, mut starts) = (Vec::new(), vec![0]);
            for (vertex, side) in (0..self.front.len()).flat_map(|vertex| [(vertex, &self.front), (vertex, &self.back)])
            {
                leaves.extend_from_slice(side.row(vertex));
                starts.push(leaves.len() as u32);
            }
            forest.leaves_beside(&leaves, starts)
        })
    }

    /// The leaves from the first to the last beside some vertices.
    pub fn span(&self, vertices: &[u32]) -> Range<u32> {
        let all = || vertices.iter().flat_map(|&vertex| self.of(vertex)).map(|(leaf, _)| leaf);
        all().min().zip(all().max()).map_or(0..0, |(first, last)| first..last + 1)
    }

    /// Values at the vertices from values at the leaves, on both sides.
    pub fn apply<T: Coefficient>(&self, leaves: &[T]) -> [Vec<T>; 2] {
        [self.front.apply(leaves), self.back.apply(leaves)]
    }
}
