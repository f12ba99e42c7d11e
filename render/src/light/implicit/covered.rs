//! Surfaces that another object lies on. Bins do not show this: they skip back faces around a leaf. The baked vertices show it as
//! baked, and rays where an object moved.

use super::{Sides, vertices::VertexLeaves};
use crate::{baked::Baked, device::layout::constants::VERTEX_IS_OPEN};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    dataset::Dataset,
    implicit::forest::{SurfelForest, nodes::Disc},
    offset,
    scene::pose::{Objects, Poses},
    surfel::{MeshPlace, Surfel},
};
use rayon::prelude::*;

/// Least open share of the leaves beside a vertex that can give it light.
pub(crate) const LEAST_OPEN: f32 = 0.05;

/// How far leaves and vertices are uncovered, as baked.
pub struct Covered {
    /// Open share by leaf, 0 to 1.
    leaves: Vec<f32>,
    leaf_positions: Vec<Vec3>,
    /// Openness by vertex, 0 or 1.
    vertices: Vec<f32>,
    vertex_positions: Vec<Vec3>,
    objects: Objects,
    /// Size of the scene in meters, without a ground.
    diagonal: f32,
}

/// Objects that moved.
pub struct Left<'a> {
    /// Their boxes as baked and now.
    boxes: Vec<[Bounds; 2]>,
    /// The posed scene.
    now: &'a Baked,
    /// Distance of a ray's start from its surface in meters.
    offset: f32,
    /// Distance in meters within which surfaces touch.
    touch: f32,
}

impl Left<'_> {
    /// Whether something covers a place of a surface that has not moved, where that may have changed: a ray along its normal meets a
    /// back face, or ends where it begins.
    fn is_covered(&self, position: Vec3, normal: Vec3) -> bool {
        let is_inside = || {
            let hit = self.now.intersector().closest_hit(position + normal * self.offset, normal);
            hit.is_some_and(|hit| {
                hit.distance < self.touch || hit.back_face && !self.now.dataset.two_sided[hit.triangle as usize]
            })
        };
        self.boxes.iter().flatten().any(|either| either.contains(position)) && is_inside()
    }

    /// Whether a place is in the box of one of them as baked, or nearer to it than `reach` in meters.
    fn was_near(&self, place: Vec3, reach: f32) -> bool {
        self.boxes.iter().any(|[as_baked, _]| as_baked.grown(reach).contains(place))
    }

    /// Whether one of them has left a place.
    fn has_left(&self, place: Vec3) -> bool {
        self.boxes.iter().any(|[as_baked, now]| as_baked.contains(place) && !now.contains(place))
    }

    /// Open share of a place, from that as baked.
    fn open(&self, as_baked: f32, was: Vec3, now: Vec3, normal: Vec3) -> f32 {
        match was == now {
            true if self.is_covered(now, normal) => 0.0,
            true if self.was_near(was, 0.0) => 1.0,
            false if self.has_left(was) => 1.0,
            _ => as_baked,
        }
    }
}

impl Covered {
    pub fn new(dataset: &Dataset, forest: &SurfelForest) -> Self {
        let mesh = &dataset.scene.mesh;
        // What the bake hid was not looked at where it would be.
        let is_open = |(&valid, object): (&bool, u32)| valid || dataset.scene.hidden.contains_key(&object);
        let vertices = dataset.vertex_valid.iter().zip(mesh.owners()).map(is_open);
        let vertices: Vec<f32> = vertices.map(|open| f32::from(u8::from(open))).collect();
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
            diagonal: mesh.bounds().diagonal(),
            vertices,
        }
    }

    /// The moved objects of `poses`; `now` is the posed scene.
    pub fn left<'a>(&self, poses: &Poses, now: &'a Baked) -> Left<'a> {
        let touch = 1e-3 * self.diagonal;
        let of_object = |object: u32| {
            let around = |positions: &[Vec3]| {
                let places = self.objects.vertices(object).iter().map(|&vertex| positions[vertex as usize]);
                Bounds::around(places).grown(touch)
            };
            [around(&self.vertex_positions), around(&now.dataset.scene.mesh.positions)]
        };
        let moved = poses.moved().filter(|&object| (object as usize) < self.objects.len());
        Left { boxes: moved.map(of_object).collect(), now, offset: offset::TRANSPORT * self.diagonal, touch }
    }

    /// Vertices that lay under an object, or so near it that their leaves did, and that it left: bins as baked see through an object
    /// from within, so these vertices have no ratio.
    pub fn footprint(&self, beside: &VertexLeaves, discs: &[Disc], left: &Left, now: &Open) -> Vec<bool> {
        let of = |(vertex, &place): (usize, &Vec3)| {
            let reach = || beside.of(vertex as u32).map(|(leaf, _)| discs[leaf as usize].radius()).fold(0.0, f32::max);
            now.vertices[vertex] > 0.0 && left.was_near(place, reach())
        };
        self.vertex_positions.par_iter().enumerate().map(of).collect()
    }

    /// Open leaves and vertices as baked.
    pub fn as_baked(&self, beside: &VertexLeaves) -> Open {
        Open { shares: beside.apply(&self.leaves), leaves: self.leaves.clone(), vertices: self.vertices.clone() }
    }

    /// Open leaves and vertices after some objects moved; `discs` are the leaves where they are now.
    pub fn open(&self, beside: &VertexLeaves, discs: &[Disc], left: &Left) -> Open {
        let places = self.leaves.par_iter().zip(&self.leaf_positions).zip(discs);
        let leaves: Vec<f32> =
            places.map(|((&open, &was), disc)| left.open(open, was, disc.position, disc.normal)).collect();
        let mesh = &left.now.dataset.scene.mesh;
        let places = self.vertices.par_iter().zip(&self.vertex_positions).zip(&mesh.positions).zip(&mesh.normals);
        let vertices = places.map(|(((&open, &was), &now), &normal)| left.open(open, was, now, normal)).collect();
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
    /// Open share of each leaf, 0 to 1.
    pub fn leaves(&self) -> &[f32] {
        &self.leaves
    }

    /// `VERTEX_...` of each vertex, with what else is known of it.
    pub fn states(&self, else_known: impl Fn(usize) -> u32 + Sync) -> Vec<u32> {
        let vertices = self.vertices.par_iter().enumerate().with_min_len(1024);
        vertices.map(|(vertex, &open)| else_known(vertex) | if open > 0.0 { VERTEX_IS_OPEN } else { 0 }).collect()
    }

    /// Values at the vertices from the open leaves' values. Covered vertices are dark.
    pub fn at_vertices(&self, beside: &VertexLeaves, leaves: &[Vec3]) -> Sides {
        let values: Vec<Vec3> = leaves.iter().zip(&self.leaves).map(|(&leaf, &open)| leaf * open).collect();
        let [front, back] = beside.apply(&values);
        let mean = |((value, &share), &open): ((Vec3, &f32), &f32)| match share >= LEAST_OPEN {
            true => value / share * open,
            false => Vec3::ZERO,
        };
        let side = |values: Vec<Vec3>, shares: &[f32]| {
            values.into_par_iter().zip(shares).zip(&self.vertices).with_min_len(1024).map(mean).collect()
        };
        Sides { front: side(front, &self.shares[0]), back: side(back, &self.shares[1]) }
    }
}
