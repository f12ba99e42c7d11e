//! Start of walks from one origin: a few dozen subtrees that together contain all triangles, the nearest first.
//!
//! Every walk from the root descends to the origin again, through boxes that contain it. Here the nodes that look
//! largest from the origin are opened once for all walks, and each walk tests the remaining boxes eight at a time.

use super::{Intersector, batch::entering};
use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use obvhs::bvh2::node::Bvh2Node;
use std::collections::BinaryHeap;

/// Largest number of subtrees; a multiple of eight.
const MOST: usize = 64;

/// Subtrees as seen from an origin; keeps its buffers.
#[derive(Default)]
pub(super) struct Frontier {
    /// Boxes relative to the origin, eight at a time; unused lanes are arbitrary.
    boxes: Vec<[Vec3x8; 2]>,
    /// Roots of the subtrees, the nearest first.
    pub roots: Vec<u32>,
    /// Nodes by apparent size, as bits of a non-negative number.
    by_size: BinaryHeap<(u32, u32)>,
    by_distance: Vec<(f32, u32)>,
}

impl Frontier {
    /// Rebuilds it for another origin.
    pub fn move_to(&mut self, scene: &Intersector, origin: Vec3) {
        let nodes = &scene.bvh.nodes[..];
        self.by_size.clear();
        self.by_distance.clear();
        if !nodes.is_empty() {
            self.open(nodes, 0, origin);
        }
        while self.by_size.len() + self.by_distance.len() < MOST
            && let Some((_, node)) = self.by_size.pop()
        {
            let first = nodes[node as usize].first_index;
            [first, first + 1].into_iter().for_each(|child| self.open(nodes, child, origin));
        }
        let rest = self.by_size.drain().map(|(_, node)| (distance_squared(&nodes[node as usize], origin), node));
        self.by_distance.extend(rest);
        self.by_distance.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.roots.clear();
        self.roots.extend(self.by_distance.iter().map(|(_, node)| *node));
        self.boxes.clear();
        for eight in self.roots.chunks(8) {
            let aabb = |lane: usize| &nodes[*eight.get(lane).unwrap_or(&eight[0]) as usize].aabb;
            let min = Vec3x8::from_array(std::array::from_fn(|lane| Vec3::from(aabb(lane).min) - origin));
            let max = Vec3x8::from_array(std::array::from_fn(|lane| Vec3::from(aabb(lane).max) - origin));
            self.boxes.push([min, max]);
        }
    }

    /// A node to be opened later, or a leaf.
    fn open(&mut self, nodes: &[Bvh2Node], index: u32, origin: Vec3) {
        let node = &nodes[index as usize];
        let distance_squared = distance_squared(node, origin);
        if node.prim_count > 0 {
            self.by_distance.push((distance_squared, index));
        } else {
            let size = node.aabb.half_area() / (distance_squared + f32::MIN_POSITIVE);
            self.by_size.push((size.min(f32::MAX).to_bits(), index));
        }
    }

    /// Subtrees, one bit each, that a ray or, if `SEGMENTS`, a segment from the origin may enter, for inverse
    /// directions between two.
    #[inline(always)]
    pub fn reached<const SEGMENTS: bool, L: Lanes>(&self, [least, most]: [Vec3; 2]) -> u64 {
        let (least, most): (Vec3x8<L>, Vec3x8<L>) = (Vec3x8::splat(least), Vec3x8::splat(most));
        let mut reached = 0;
        for (eight, [min, max]) in self.boxes.iter().enumerate() {
            let (min, max): (Vec3x8<L>, Vec3x8<L>) = (Vec3x8::load(min), Vec3x8::load(max));
            let (near_x, far_x) = slab(min.x, max.x, least.x, most.x);
            let (near_y, far_y) = slab(min.y, max.y, least.y, most.y);
            let (near_z, far_z) = slab(min.z, max.z, least.z, most.z);
            let entry = near_x.fast_max(near_y).fast_max(near_z.fast_max(L::splat(0.0)));
            let exit = far_x.fast_min(far_y).fast_min(far_z);
            reached |= u64::from(entering::<SEGMENTS, L>((entry, exit))) << (8 * eight);
        }
        // Lanes past the last are not boxes.
        reached & u64::MAX.checked_shr(64 - self.roots.len() as u32).unwrap_or(0)
    }
}

/// Squared distance of a box from a point.
fn distance_squared(node: &Bvh2Node, origin: Vec3) -> f32 {
    origin.distance_squared(origin.clamp(node.aabb.min.into(), node.aabb.max.into()))
}

/// Least and greatest parameters within the slab from `min` to `max`, for any inverse from `least` to `most`.
#[inline(always)]
fn slab<L: Lanes>(min: L, max: L, least: L, most: L) -> (L, L) {
    let (a, b, c, d) = (min * least, min * most, max * least, max * most);
    (a.fast_min(b).fast_min(c.fast_min(d)), a.fast_max(b).fast_max(c.fast_max(d)))
}

const _: () = assert!(MOST.is_multiple_of(8) && MOST <= 64);
