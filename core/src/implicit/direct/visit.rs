//! The walk of one receiver through a forest, which selects the nodes to treat as discs.

use crate::{
    implicit::forest::{
        nodes::{Block, Four},
        quadtrees::CHILDREN,
    },
    simd::{Lanes, Vec3x8},
};
use glam::{Mat3, Vec3};

/// Sine of the elevation above which nodes and receivers see each other; lower ones are rounding within one surface.
pub const GRAZING: f32 = 1e-4;
/// Squared sine below which a node counts as parallel to the receiver.
pub const PARALLEL: f32 = 1e-6;

/// Place of a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// In meters.
    pub position: Vec3,
    /// Its tangents and its normal.
    pub frame: Mat3,
}

/// Blocks to visit. Keeps its memory between receivers.
#[derive(Default)]
pub struct Visits {
    waiting: Vec<u32>,
    /// Numbers of the selected nodes.
    pub ends: Vec<u32>,
}

impl Visits {
    /// Selects the nodes to treat as discs. `roots` holds the first blocks, with only the objects to walk; `limit` is
    /// the largest integral of the cosine over a node, in steradians.
    #[inline(always)]
    pub fn find<L: Lanes>(&mut self, roots: &[Block], blocks: &[Block], receiver: &Receiver, limit: f32) {
        self.ends.clear();
        let empty = Block::default();
        for (pair, numbers) in roots.chunks(2).zip((0..).step_by(2)) {
            self.visit::<L>([&pair[0], pair.get(1).unwrap_or(&empty)], [numbers, numbers + 1], receiver, limit);
        }
        while let Some(first) = self.waiting.pop() {
            let second = self.waiting.pop().unwrap_or(0);
            let other = if second == 0 { &empty } else { &blocks[second as usize] };
            self.visit::<L>([&blocks[first as usize], other], [first, second], receiver, limit);
        }
    }

    /// Sorts the nodes of two blocks into nodes to descend below, selected nodes, and nodes that do not count.
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, pair: [&Block; 2], numbers: [u32; 2], receiver: &Receiver, limit: f32) {
        let Sorted { mut descend, mut end } = sort::<L>(pair, receiver, limit);
        while descend != 0 {
            let lane = descend.trailing_zeros() as usize;
            descend &= descend - 1;
            self.waiting.push(pair[lane / CHILDREN].below[lane % CHILDREN]);
        }
        while end != 0 {
            let lane = end.trailing_zeros();
            end &= end - 1;
            self.ends.push(numbers[lane as usize / CHILDREN] * CHILDREN as u32 + lane % CHILDREN as u32);
        }
    }
}

/// Classes of eight nodes, as masks.
struct Sorted {
    descend: u32,
    end: u32,
}

#[inline(always)]
fn sort<L: Lanes>(pair: [&Block; 2], receiver: &Receiver, limit: f32) -> Sorted {
    let normal = Vec3x8::<L>::splat(receiver.frame.z_axis);
    let offset = vectors::<L>([&pair[0].center, &pair[1].center]) - Vec3x8::splat(receiver.position);
    let axis = vectors::<L>([&pair[0].axis, &pair[1].axis]);
    let numbers = |of: fn(&Block) -> &Four| eight::<L>([of(pair[0]), of(pair[1])]);
    let (area, radius, thickness) = (numbers(|b| &b.area), numbers(|b| &b.radius), numbers(|b| &b.thickness));
    let distance_sq = offset.dot(offset);
    let distance = distance_sq.sqrt();
    let grazing = distance * L::splat(GRAZING);

    // Whether any part is in front of the receiver: the node lies within a flat cylinder around its axis.
    let height = offset.dot(normal);
    let parallel = normal.dot(axis);
    let sine = (L::splat(1.0 - PARALLEL) - parallel * parallel).at_least(0.0).sqrt();
    let top = height + radius * sine + thickness * parallel.abs();

    // Whether any part can face the receiver. All terms are in units of the distance.
    let toward = -offset.dot(axis);
    let cone_sin = numbers(|b| &b.cone_sin);
    let across = (distance_sq - toward * toward).at_least(0.0).sqrt();
    let facing = toward * numbers(|b| &b.cone_cos) + (across + radius) * cone_sin + thickness;

    let projected = area * visible_share(numbers(|b| &b.coherence), toward, distance_sq);
    let is_large = (projected * top.fast_min(distance)).simd_gt(L::splat(limit) * distance_sq * distance_sq);
    let is_near = distance_sq.simd_lt(radius * radius);
    let is_under = height.simd_le(grazing);
    let counts = area.simd_gt(L::splat(0.0)) & top.simd_gt(grazing) & facing.simd_gt(grazing);
    let counts = counts.to_bitmask();
    let descend = counts & inner(pair) & (is_large | is_near | is_under).to_bitmask();
    Sorted { descend, end: counts & !descend & !is_under.to_bitmask() }
}

/// The visible share of the nodes' areas, times the distance. `toward` is the distance times the cosine between axis
/// and receiver. The share is the positive cosine for a flat node, and a quarter for a sphere.
#[inline(always)]
pub fn visible_share<L: Lanes>(coherence: L, toward: L, distance_sq: L) -> L {
    let mean = coherence * toward;
    let spread = (L::splat(1.0) - coherence * coherence) * L::splat(0.25) * distance_sq;
    L::splat(0.5) * (mean + (mean * mean + spread).sqrt())
}

/// Mask of the nodes with children.
#[inline(always)]
fn inner(pair: [&Block; 2]) -> u32 {
    let mut bits = 0;
    for slot in 0..CHILDREN {
        bits |= u32::from(pair[0].below[slot] != 0) << slot | u32::from(pair[1].below[slot] != 0) << (slot + CHILDREN);
    }
    bits
}

#[inline(always)]
fn eight<L: Lanes>([a, b]: [&Four; 2]) -> L {
    L::new([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]])
}

#[inline(always)]
fn vectors<L: Lanes>([a, b]: [&[Four; 3]; 2]) -> Vec3x8<L> {
    Vec3x8 { x: eight([&a[0], &b[0]]), y: eight([&a[1], &b[1]]), z: eight([&a[2], &b[2]]) }
}
