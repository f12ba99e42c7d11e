//! Boundaries between blocked and unblocked directions.

use super::{
    follow::{Follow, Rays, State},
    graph::Graph,
};
use crate::{
    ray::{
        Intersector, OPEN,
        directions::{GROUP, HalfSpace, spatial_order},
        frontier::Frontier,
        group::RayGroup,
    },
    simd::{InstructionSet, Lanes},
};
use glam::{IVec3, Vec3};
use std::{collections::HashMap, f32::consts::PI};

/// Number of nearest directions that count as neighbors: evenly spread directions touch six others.
const NEIGHBOURS: usize = 6;

/// Directions with their neighbors, in groups of eight and in blocks with a probe each.
pub struct BoundarySet {
    graph: Graph,
    /// The rays of each group of the graph.
    groups: Vec<RayGroup>,
    /// Probes of eight consecutive blocks each.
    probes: Vec<Probes>,
}

/// The probes of eight blocks, or of fewer at the end.
struct Probes {
    rays: RayGroup,
    /// Position of each in the caller's order.
    targets: Vec<u32>,
}

impl BoundarySet {
    /// Creates a set of unit `directions` with one probe per block of `directions_per_probe`, a multiple of eight.
    pub fn new(directions: &[Vec3], directions_per_probe: usize) -> Self {
        let order = spatial_order(directions);
        let rays = |members: &[u32]| {
            let members: Vec<Vec3> = members.iter().map(|&i| directions[i as usize]).collect();
            RayGroup::new(&members)
        };
        let graph = Graph::new(&order, &neighbours(directions), directions_per_probe);
        let probes: Vec<u32> = order.chunks(directions_per_probe).map(|block| central(block, directions)).collect();
        let probes = probes.chunks(GROUP).map(|eight| Probes { rays: rays(eight), targets: eight.to_vec() });
        Self { groups: order.chunks(GROUP).map(rays).collect(), probes: probes.collect(), graph }
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.graph.len
    }

    /// Whether there are no directions.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The member nearest to the members' mean.
fn central(members: &[u32], directions: &[Vec3]) -> u32 {
    let along = |&i: &u32| directions[i as usize];
    let mean: Vec3 = members.iter().map(along).sum();
    members.iter().copied().max_by(|a, b| along(a).dot(mean).total_cmp(&along(b).dot(mean))).unwrap_or(0)
}

/// The [`NEIGHBOURS`] nearest others of each direction, if some cells of a grid contain as many.
fn neighbours(directions: &[Vec3]) -> Vec<Vec<u32>> {
    // Slightly more than the spacing of this many directions on the sphere.
    let side = 1.2 * (4.0 * PI / directions.len() as f32).sqrt();
    let cell = |d: Vec3| (d / side).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::new();
    directions.iter().zip(0..).for_each(|(&d, i)| cells.entry(cell(d)).or_default().push(i));
    let around = |at: IVec3| (0..27).map(move |i| at + IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    let nearest = |(own, &d): (u32, &Vec3)| {
        let others = around(cell(d)).filter_map(|at| cells.get(&at)).flatten().copied().filter(|&i| i != own);
        let mut others: Vec<(f32, u32)> = others.map(|i| (d.distance_squared(directions[i as usize]), i)).collect();
        others.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        others.into_iter().take(NEIGHBOURS).map(|(_, i)| i).collect()
    };
    (0..).zip(directions).map(nearest).collect()
}

/// Follows the boundaries of origin after origin; keeps its buffers.
#[derive(Default)]
pub struct BoundaryTracer {
    state: State,
    stack: Vec<(u32, u8)>,
    frontier: Frontier,
}

impl BoundaryTracer {
    /// Sets `visible[i]` to [`OPEN`] for directions within `half` that seem unblocked from `origin`. Other entries stay
    /// unchanged. Returns the number of rays traced.
    ///
    /// `visible` has one entry per direction, in the order of the set's creation.
    pub fn trace(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        set: &BoundarySet,
        half: &HalfSpace,
        visible: &mut [u8],
    ) -> u64 {
        self.trace_some(scene, origin, set, (half, None), visible)
    }

    /// [`Self::trace`] for the directions that are marked, if any are.
    pub fn trace_some(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        set: &BoundarySet,
        wanted: (&HalfSpace, Option<&[bool]>),
        visible: &mut [u8],
    ) -> u64 {
        let Self { state, stack, frontier } = self;
        frontier.move_to(scene, origin);
        let traced = Traced { scene, origin, frontier, stack };
        Self::run(state, set, wanted, traced, visible)
    }

    /// [`Self::trace`] for rays traced elsewhere: the bits of `open` mark unblocked directions.
    pub fn follow(&mut self, open: &[u32], set: &BoundarySet, half: &HalfSpace, visible: &mut [u8]) {
        Self::run(&mut self.state, set, (half, None), Told(open), visible);
    }

    fn run(
        state: &mut State,
        set: &BoundarySet,
        (half, marked): (&HalfSpace, Option<&[bool]>),
        meet: impl Meet,
        visible: &mut [u8],
    ) -> u64 {
        let rays = Directions { set, half, marked, meet };
        let count = InstructionSet::widest().run(Follow { graph: &set.graph, rays, state });
        assert_eq!(visible.len(), set.len(), "one visibility a direction");
        for (group, &open) in set.graph.groups.iter().zip(&state.open) {
            let mut rest = open;
            while rest != 0 {
                visible[group.targets[rest.trailing_zeros() as usize] as usize] = OPEN;
                rest &= rest - 1;
            }
        }
        count
    }
}

/// Determines which rays are unblocked.
trait Meet {
    /// The unblocked rays of `active`, one bit each. `targets` are their positions in the caller's order.
    fn open<L: Lanes>(&mut self, rays: &RayGroup, targets: &[u32], active: u8) -> u8;
}

/// Traces the rays.
struct Traced<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    frontier: &'a Frontier,
    stack: &'a mut Vec<(u32, u8)>,
}

impl Meet for Traced<'_> {
    #[inline(always)]
    fn open<L: Lanes>(&mut self, rays: &RayGroup, _: &[u32], active: u8) -> u8 {
        rays.open::<false, L>(self.scene, self.frontier, self.origin, active, self.stack)
    }
}

/// Looks the rays up: a bit per direction.
struct Told<'a>(&'a [u32]);

impl Meet for Told<'_> {
    #[inline(always)]
    fn open<L: Lanes>(&mut self, _: &RayGroup, targets: &[u32], active: u8) -> u8 {
        let bit = |&target: &u32| (self.0[target as usize / 32] >> (target % 32)) as u8 & 1;
        active & targets.iter().enumerate().fold(0, |open, (lane, target)| open | bit(target) << lane)
    }
}

/// The first `count` of eight lanes.
fn lanes_below(count: usize) -> u8 {
    ((1_u32 << count) - 1) as u8
}

/// The directions of a set within a half-space, of which only the marked ones are wanted, if any are marked.
struct Directions<'a, M> {
    set: &'a BoundarySet,
    half: &'a HalfSpace,
    marked: Option<&'a [bool]>,
    meet: M,
}

impl<M> Directions<'_, M> {
    /// The wanted lanes of some directions.
    #[inline(always)]
    fn wanted<L: Lanes>(&self, rays: &RayGroup, targets: &[u32]) -> u8 {
        let within = rays.within::<L>(self.half) & lanes_below(targets.len());
        let Some(marked) = self.marked.filter(|_| within != 0) else { return within };
        let bit = |(lane, &target): (usize, &u32)| u8::from(marked[target as usize]) << lane;
        within & targets.iter().enumerate().map(bit).fold(0, |all, bit| all | bit)
    }
}

impl<M: Meet> Rays for Directions<'_, M> {
    #[inline(always)]
    fn probe<L: Lanes>(&mut self, state: &mut State) -> u64 {
        let set = self.set;
        for (rays, group) in set.groups.iter().zip(&set.graph.groups) {
            state.wanted.push(self.wanted::<L>(rays, &group.targets));
        }
        let mut count = 0;
        for probes in &set.probes {
            let active = self.wanted::<L>(&probes.rays, &probes.targets);
            count += u64::from(active.count_ones());
            let open = if active == 0 { 0 } else { self.meet.open::<L>(&probes.rays, &probes.targets, active) };
            for lane in 0..probes.targets.len() {
                state.predict((active >> lane & 1 == 1).then_some(open >> lane & 1 == 1));
            }
        }
        count
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, group: usize, active: u8) -> u8 {
        self.meet.open::<L>(&self.set.groups[group], &self.set.graph.groups[group].targets, active)
    }
}
