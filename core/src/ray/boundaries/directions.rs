//! Boundaries between blocked and unblocked directions.

use super::{
    follow::{Follow, Rays, State},
    graph::{Graph, Group},
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
#[derive(Clone)]
pub struct BoundarySet {
    graph: Graph,
    /// The rays of each group of the graph.
    groups: Vec<RayGroup>,
    /// Probes of eight consecutive blocks each.
    probes: Vec<Probes>,
}

/// The probes of eight blocks, or of fewer at the end.
#[derive(Clone)]
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

/// A set as tables, for devices.
pub struct BoundaryTables {
    /// Unit directions, group by group. A group has eight, the last one may have fewer.
    pub directions: Vec<Vec3>,
    /// Position of each of them in the caller's order.
    pub targets: Vec<u32>,
    /// For each block, the position of its probe among `directions`.
    pub probes: Vec<u32>,
    /// Groups of a block; the last block may have fewer.
    pub groups_per_block: usize,
    /// For each group the numbers of the groups that touch it. A bit marks each of its lanes with a neighbor in the other group.
    pub touching: Vec<Vec<(u32, u8)>>,
}

impl BoundarySet {
    /// The set as tables.
    pub fn tables(&self) -> BoundaryTables {
        let Graph { groups, block, .. } = &self.graph;
        let lanes = |(rays, group): (&RayGroup, &Group)| {
            let rays = rays.rays;
            (0..group.targets.len()).map(move |lane| rays.lane(lane))
        };
        let targets: Vec<u32> = groups.iter().flat_map(|group| &group.targets).copied().collect();
        let mut places = vec![0; targets.len()];
        (0..).zip(&targets).for_each(|(place, &target)| places[target as usize] = place);
        let place_of = |target: &u32| places[*target as usize];
        let touching = |group: &Group| group.touching.iter().map(|other| (other.group, other.lanes)).collect();
        BoundaryTables {
            directions: self.groups.iter().zip(groups).flat_map(lanes).collect(),
            probes: self.probes.iter().flat_map(|probes| &probes.targets).map(place_of).collect(),
            groups_per_block: *block,
            touching: groups.iter().map(touching).collect(),
            targets,
        }
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
        let (half, marked) = wanted;
        frontier.move_to(scene, origin);
        let rays = Directions { scene, origin, set, half, marked, frontier, stack };
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

/// The first `count` of eight lanes.
fn lanes_below(count: usize) -> u8 {
    ((1_u32 << count) - 1) as u8
}

/// The directions of a set within a half-space, of which only the marked ones are wanted, if any are marked.
struct Directions<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    set: &'a BoundarySet,
    half: &'a HalfSpace,
    marked: Option<&'a [bool]>,
    frontier: &'a Frontier,
    stack: &'a mut Vec<(u32, u8)>,
}

impl Directions<'_> {
    /// The wanted lanes of some directions.
    #[inline(always)]
    fn wanted<L: Lanes>(&self, rays: &RayGroup, targets: &[u32]) -> u8 {
        let within = rays.within::<L>(self.half) & lanes_below(targets.len());
        let Some(marked) = self.marked.filter(|_| within != 0) else { return within };
        let bit = |(lane, &target): (usize, &u32)| u8::from(marked[target as usize]) << lane;
        within & targets.iter().enumerate().map(bit).fold(0, |all, bit| all | bit)
    }

    /// The unblocked rays of `active`, one bit each.
    #[inline(always)]
    fn open_of<L: Lanes>(&mut self, rays: &RayGroup, active: u8) -> u8 {
        rays.open::<false, L>(self.scene, self.frontier, self.origin, active, self.stack)
    }
}

impl Rays for Directions<'_> {
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
            let open = if active == 0 { 0 } else { self.open_of::<L>(&probes.rays, active) };
            for lane in 0..probes.targets.len() {
                state.predict((active >> lane & 1 == 1).then_some(open >> lane & 1 == 1));
            }
        }
        count
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, group: usize, active: u8) -> u8 {
        self.open_of::<L>(&self.set.groups[group], active)
    }
}
