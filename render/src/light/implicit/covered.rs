//! Surfaces that another object lies on. Bins do not show this: they skip back faces around a leaf. The baked vertices do.

use super::{Sides, vertices::VertexLeaves};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    dataset::Dataset,
    implicit::forest::{SurfelForest, nodes::Disc},
    scene::{
        Mesh,
        pose::{Objects, Poses},
    },
    surfel::{MeshPlace, Surfel},
};
use rayon::prelude::*;

/// Least open share of the leaves beside a vertex that can give it light.
const LEAST_OPEN: f32 = 0.05;

/// How far leaves and vertices are uncovered, as baked.
pub struct Covered {
    /// Open share by leaf, 0 to 1.
    leaves: Vec<f32>,
    leaf_positions: Vec<Vec3>,
    /// Openness by vertex, 0 or 1.
    vertices: Vec<f32>,
    vertex_positions: Vec<Vec3>,
    objects: Objects,
}

/// Boxes of an object that moved, as baked and now.
pub struct Left {
    as_baked: Bounds,
    now: Bounds,
}

impl Left {
    /// Whether the object covered a place and has left it.
    fn uncovers(&self, place: Vec3) -> bool {
        self.as_baked.contains(place) && !self.now.contains(place)
    }
}

impl Covered {
    pub fn new(dataset: &Dataset, forest: &SurfelForest) -> Self {
        let mesh = &dataset.scene.mesh;
        let vertices: Vec<f32> = dataset.vertex_valid.iter().map(|&valid| f32::from(u8::from(valid))).collect();
        let open = |at: &Surfel| {
            let MeshPlace { triangle, barycentric: b } = at.place;
            let corners = mesh.triangles[triangle as usize].iter().zip([1.0 - b.x - b.y, b.x, b.y]);
            corners.map(|(&vertex, weight)| vertices[vertex as usize] * weight).sum()
        };
        Self {
            leaves: forest.surfels().map(|surfel| open(&surfel)).collect(),
            leaf_positions: forest.surfels().map(|surfel| surfel.position).collect(),
            vertex_positions: mesh.positions.clone(),
            objects: Objects::of(&dataset.scene),
            vertices,
        }
    }

    /// Boxes of the moved objects of `poses`; `posed` is the mesh in these poses.
    pub fn left(&self, poses: &Poses, posed: &Mesh) -> Vec<Left> {
        let margin = 1e-3 * Bounds::around(self.vertex_positions.iter().copied()).diagonal();
        let of_object = |object: u32| {
            let around = |positions: &[Vec3]| {
                let places = self.objects.vertices(object).iter().map(|&vertex| positions[vertex as usize]);
                Bounds::around(places).grown(margin)
            };
            Left { as_baked: around(&self.vertex_positions), now: around(&posed.positions) }
        };
        poses.moved().filter(|&object| (object as usize) < self.objects.len()).map(of_object).collect()
    }

    /// Vertices that lay under an object, or so near it that their leaves did, and that it left: bins as baked see through an object
    /// from within, so these vertices have no ratio.
    pub fn footprint(&self, beside: &VertexLeaves, discs: &[Disc], left: &[Left]) -> Vec<bool> {
        let of = |(vertex, &position): (usize, &Vec3)| {
            let reach = || beside.of(vertex as u32).map(|(leaf, _)| discs[leaf as usize].radius()).fold(0.0, f32::max);
            left.iter()
                .any(|object| !object.now.contains(position) && object.as_baked.grown(reach()).contains(position))
        };
        self.vertex_positions.par_iter().enumerate().map(of).collect()
    }

    /// Open leaves and vertices after the objects in `left` have moved away.
    pub fn open(&self, beside: &VertexLeaves, left: &[Left]) -> Open {
        let leaves = uncovered(&self.leaves, &self.leaf_positions, left);
        let vertices = uncovered(&self.vertices, &self.vertex_positions, left);
        Open { shares: beside.apply(&leaves), leaves, vertices }
    }
}

/// How far leaves and vertices are uncovered.
pub struct Open {
    /// Open share by leaf, 0 to 1.
    leaves: Vec<f32>,
    /// Openness by vertex, 0 or 1.
    vertices: Vec<f32>,
    /// Mean open shares of the leaves beside the vertices, on both sides.
    shares: [Vec<f32>; 2],
}

impl Open {
    /// Open share of a leaf, 0 to 1.
    pub fn leaf(&self, leaf: u32) -> f32 {
        self.leaves[leaf as usize]
    }

    /// Values at the vertices from the open leaves' values. Covered vertices are dark.
    pub fn at_vertices(&self, beside: &VertexLeaves, leaves: &[Vec3]) -> Sides {
        let values: Vec<Vec3> = leaves.iter().zip(&self.leaves).map(|(&leaf, &open)| leaf * open).collect();
        let [front, back] = beside.apply(&values);
        let mean = |((value, &share), &open): ((Vec3, &f32), &f32)| match share >= LEAST_OPEN {
            true => value / share * open,
            false => Vec3::ZERO,
        };
        let side =
            |values: Vec<Vec3>, shares: &[f32]| values.into_iter().zip(shares).zip(&self.vertices).map(mean).collect();
        Sides { front: side(front, &self.shares[0]), back: side(back, &self.shares[1]) }
    }
}

/// Open shares of places after some objects have left.
fn uncovered(as_baked: &[f32], positions: &[Vec3], left: &[Left]) -> Vec<f32> {
    let open = |(&open, &position): (&f32, &Vec3)| {
        if open < 1.0 && left.iter().any(|object| object.uncovers(position)) { 1.0 } else { open }
    };
    as_baked.iter().zip(positions).map(open).collect()
}
