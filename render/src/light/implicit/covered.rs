//! What something lies on. Bins do not tell: they skip the backs of what a leaf is inside. A bake has found the vertices.

use super::{Sides, vertices::VertexLeaves};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    dataset::Dataset,
    implicit::forest::SurfelForest,
    scene::{
        Mesh,
        pose::{Objects, Poses},
    },
    surfel::{MeshPlace, Surfel},
};

/// Share of open leaves beside a vertex below which their light says nothing of it.
const LEAST_OPEN: f32 = 0.05;

/// How much of leaves and vertices nothing lies on, as baked.
pub struct Covered {
    /// By leaf, 0 to 1.
    leaves: Vec<f32>,
    leaf_positions: Vec<Vec3>,
    /// By vertex, 0 or 1.
    vertices: Vec<f32>,
    vertex_positions: Vec<Vec3>,
    objects: Objects,
}

/// The box of an object that moved.
pub struct Left {
    as_baked: Bounds,
    now: Bounds,
}

impl Left {
    /// Whether it was at a place that it has left.
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

    /// What the objects of `poses` have left in the mesh that is `posed` so.
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

    /// What lies open where objects have left.
    pub fn open(&self, beside: &VertexLeaves, left: &[Left]) -> Open {
        let leaves = uncovered(&self.leaves, &self.leaf_positions, left);
        let vertices = uncovered(&self.vertices, &self.vertex_positions, left);
        Open { shares: beside.apply(&leaves), leaves, vertices }
    }
}

/// How much of leaves and vertices nothing lies on.
pub struct Open {
    /// By leaf, 0 to 1.
    leaves: Vec<f32>,
    /// By vertex, 0 or 1.
    vertices: Vec<f32>,
    /// Means of the leaves beside the vertices, on both sides.
    shares: [Vec<f32>; 2],
}

impl Open {
    /// Values of vertices from those of leaves: of what lies open. Covered vertices are dark.
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

/// How much of places nothing lies on.
fn uncovered(as_baked: &[f32], positions: &[Vec3], left: &[Left]) -> Vec<f32> {
    let open = |(&open, &position): (&f32, &Vec3)| {
        if open < 1.0 && left.iter().any(|object| object.uncovers(position)) { 1.0 } else { open }
    };
    as_baked.iter().zip(positions).map(open).collect()
}
