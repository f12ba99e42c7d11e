//! What something lies on. Bins do not tell: they skip the backs of what a leaf is inside. A bake has found the vertices.

use super::{Sides, vertices::VertexLeaves};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    dataset::Dataset,
    scene::pose::{Objects, Poses},
    surfel::{MeshPlace, Surfel, forest::SurfelForest},
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
    /// Around each object.
    boxes: Vec<Bounds>,
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
        let objects = Objects::of(&dataset.scene);
        let around = |object| {
            let places = objects.vertices(object).iter().map(|&vertex| mesh.positions[vertex as usize]);
            Bounds::around(places).grown(1e-3 * mesh.bounds().diagonal())
        };
        Self {
            leaves: forest.surfels().map(|surfel| open(&surfel)).collect(),
            leaf_positions: forest.surfels().map(|surfel| surfel.position).collect(),
            vertex_positions: mesh.positions.clone(),
            boxes: (0..objects.len() as u32).map(around).collect(),
            vertices,
        }
    }

    /// Values of vertices from those of leaves: of what lies open as baked, or under poses. Covered vertices are dark.
    pub fn at_vertices(&self, beside: &VertexLeaves, leaves: Vec<Vec3>, poses: Option<&Poses>) -> Sides {
        let open = self.uncovered(&self.leaves, &self.leaf_positions, poses);
        let values: Vec<Vec3> = leaves.iter().zip(&open).map(|(&leaf, &open)| leaf * open).collect();
        let [values, shares] =
            [values, open.into_iter().map(Vec3::splat).collect()].map(|leaves| beside.apply(&leaves));
        let vertices = self.uncovered(&self.vertices, &self.vertex_positions, poses);
        let mean = |((&value, share), &open): ((&Vec3, &Vec3), &f32)| match share.x >= LEAST_OPEN {
            true => value / share.x * open,
            false => Vec3::ZERO,
        };
        let side = |values: &[Vec3], shares: &[Vec3]| values.iter().zip(shares).zip(&vertices).map(mean).collect();
        Sides { front: side(&values.front, &shares.front), back: side(&values.back, &shares.back) }
    }

    /// Nothing lies any more on what is in the box of an object that moved away.
    fn uncovered(&self, as_baked: &[f32], positions: &[Vec3], poses: Option<&Poses>) -> Vec<f32> {
        let moved = poses.iter().flat_map(|poses| poses.moved());
        let left: Vec<&Bounds> = moved.filter_map(|object| self.boxes.get(object as usize)).collect();
        let open = |(&open, position): (&f32, &Vec3)| {
            let is_left = || left.iter().any(|bounds| bounds.contains(*position));
            if open < 1.0 && is_left() { 1.0 } else { open }
        };
        as_baked.iter().zip(positions).map(open).collect()
    }
}
