//! Boundaries between hidden and visible points.

use super::{
    follow::{Follow, Rays, State},
    graph::Graph,
};
use crate::{
    ray::{Intersector, directions::GROUP, frontier::Frontier, group::RayGroup},
    simd::{InstructionSet, Lanes},
};
use glam::Vec3;

/// Points with their neighbors, in groups of eight and in blocks with a probe each.
pub struct SegmentSet {
    graph: Graph,
    ends: Vec<Vec3>,
}

impl SegmentSet {
    /// A set of points in an order where each run of eight lies close together. Each has a list of neighbors on the
    /// same surface. There is one probe per block of `points_per_probe`, a multiple of eight.
    pub fn new(ends: Vec<Vec3>, neighbours: &[Vec<u32>], points_per_probe: usize) -> Self {
        let order: Vec<u32> = (0..ends.len() as u32).collect();
        Self { graph: Graph::new(&order, neighbours, points_per_probe), ends }
    }
}

/// Follows the boundaries of origin after origin; keeps its buffers.
#[derive(Default)]
pub struct SegmentTracer {
    state: State,
    /// Per group, the requested lanes.
    wanted: Vec<u8>,
    stack: Vec<(u32, u8)>,
    frontier: Frontier,
}

impl SegmentTracer {
    /// Calls `hidden(i)`, in any order, for each of `wanted` (points of the set) that seems hidden from the origin.
    /// Both ends of a segment lie off any surface. Returns the number of segments traced.
    pub fn trace(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        set: &SegmentSet,
        wanted: &[u32],
        mut hidden: impl FnMut(u32),
    ) -> u64 {
        let Self { state, wanted: lanes, stack, frontier } = self;
        lanes.clear();
        lanes.resize(set.graph.groups.len(), 0);
        wanted.iter().for_each(|&i| lanes[i as usize / GROUP] |= 1 << (i as usize % GROUP));
        frontier.move_to(scene, origin);
        let rays = Segments { scene, origin, set, wanted: lanes, frontier, stack };
        let count = InstructionSet::widest().run(Follow { graph: &set.graph, rays, state });
        wanted
            .iter()
            .filter(|&&i| state.open[i as usize / GROUP] >> (i as usize % GROUP) & 1 == 0)
            .for_each(|&i| hidden(i));
        count
    }
}

/// The segments from an origin to some points of a set.
struct Segments<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    set: &'a SegmentSet,
    /// Per group, the requested lanes.
    wanted: &'a [u8],
    frontier: &'a Frontier,
    stack: &'a mut Vec<(u32, u8)>,
}

impl Segments<'_> {
    /// The visible ones of up to eight points, one bit each.
    #[inline(always)]
    fn open_to<L: Lanes>(&mut self, targets: &[u32], active: u8) -> u8 {
        let first = active.trailing_zeros() as usize;
        // Lanes that are not requested would widen the cone.
        let lane = |lane: usize| if active >> lane & 1 == 1 { lane } else { first };
        let segments = std::array::from_fn(|i| self.set.ends[targets[lane(i)] as usize] - self.origin);
        let rays = RayGroup::of_segments(segments);
        rays.open::<true, L>(self.scene, self.frontier, self.origin, active, self.stack)
    }
}

impl Rays for Segments<'_> {
    #[inline(always)]
    fn probe<L: Lanes>(&mut self, state: &mut State) -> u64 {
        state.wanted.extend_from_slice(self.wanted);
        let (block, mut count) = (self.set.graph.block, 0);
        let mut first = 0;
        for blocks in self.wanted.chunks(GROUP * block) {
            let (mut probes, mut active) = ([0; GROUP], 0);
            for (lane, wanted) in blocks.chunks(block).enumerate() {
                if let Some(middle) = middle(wanted) {
                    probes[lane] = first + middle;
                    active |= 1 << lane;
                }
                first += (GROUP * wanted.len()) as u32;
            }
            let open = if active == 0 { 0 } else { self.open_to::<L>(&probes, active) };
            for lane in 0..blocks.len().div_ceil(block) {
                state.predict((active >> lane & 1 == 1).then_some(open >> lane & 1 == 1));
            }
            count += u64::from(active.count_ones());
        }
        count
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, group: usize, active: u8) -> u8 {
        let set = self.set;
        self.open_to::<L>(&set.graph.groups[group].targets, active)
    }
}

/// The middle of the requested lanes in some groups, counted from the first lane of the first group.
#[inline(always)]
fn middle(wanted: &[u8]) -> Option<u32> {
    let mut before = wanted.iter().map(|lanes| lanes.count_ones()).sum::<u32>() / 2;
    for (&lanes, first) in wanted.iter().zip((0..).step_by(GROUP)) {
        if before < lanes.count_ones() {
            let rest = (0..before).fold(lanes, |rest, _| rest & (rest - 1));
            return Some(first + rest.trailing_zeros());
        }
        before -= lanes.count_ones();
    }
    None
}
