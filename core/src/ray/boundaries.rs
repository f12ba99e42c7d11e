//! Occlusion of a whole direction set from one origin, by the boundaries of what is seen.
//!
//! Visibility changes along boundaries: nine rays of ten tell nothing new. One probe is traced in each block of directions,
//! and stands for its block. Where blocks that touch differ, a boundary runs between them, and is followed: eight
//! directions of the seen side are traced, and each eight whose neighbours differ from what is known or predicted of it,
//! until nothing is left to trace. What no probe meets and no boundary leads to is missed. An audit against
//! `ray::batch` says how much that is.
//!
//! The result of an origin depends on nothing but it: not on other origins, and not on the order in which eights are traced.

use super::{
    Intersector,
    directions::{GROUP, HalfSpace, spatial_order},
    frontier::Frontier,
    group::RayGroup,
};
use crate::simd::{InstructionSet, Kernel, Lanes};
use glam::{IVec3, Vec3};
use std::{
    collections::{BTreeMap, HashMap},
    f32::consts::PI,
};

/// Nearest directions of each that count as its neighbours: directions spread evenly touch six others.
const NEIGHBOURS: usize = 6;

/// Directions with their neighbours, in groups of eight and in blocks with a probe each.
pub struct BoundarySet {
    groups: Vec<Group>,
    /// Eight probes each, of eight blocks one after the other.
    probes: Vec<Probes>,
    /// Groups in a block.
    block: usize,
    len: usize,
}

/// Eight directions that lie close together.
struct Group {
    rays: RayGroup,
    /// Where each stands in the caller's order.
    targets: Vec<u32>,
    /// Groups that touch this one.
    touching: Vec<Touching>,
}

/// The probes of eight blocks, or of fewer at the end.
struct Probes {
    rays: RayGroup,
    /// Where each stands in the caller's order.
    targets: Vec<u32>,
}

/// A group that touches another.
struct Touching {
    group: u32,
    /// Lanes of that other one that have a neighbour in it.
    lanes: u8,
}

impl BoundarySet {
    /// One probe in each block of `directions_per_probe` of the unit `directions`; a multiple of eight.
    pub fn new(directions: &[Vec3], directions_per_probe: usize) -> Self {
        assert!(directions_per_probe > 1 && Self::is_number_per_probe(directions_per_probe), "{directions_per_probe}");
        let order = spatial_order(directions);
        let of = |members: &[u32]| -> Vec<Vec3> { members.iter().map(|&i| directions[i as usize]).collect() };
        let groups = order.chunks(GROUP).zip(touching(&order, directions)).map(|(members, touching)| Group {
            rays: RayGroup::new(&of(members)),
            targets: members.to_vec(),
            touching,
        });
        let probes: Vec<u32> = order.chunks(directions_per_probe).map(|block| central(block, directions)).collect();
        let probes =
            probes.chunks(GROUP).map(|eight| Probes { rays: RayGroup::new(&of(eight)), targets: eight.to_vec() });
        Self {
            groups: groups.collect(),
            probes: probes.collect(),
            block: directions_per_probe / GROUP,
            len: directions.len(),
        }
    }

    /// Whether a probe can stand for so many directions: a multiple of eight, or 1 where all are traced.
    pub fn is_number_per_probe(directions: usize) -> bool {
        directions == 1 || (directions > 0 && directions.is_multiple_of(GROUP))
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

/// That of the members which is nearest to their mean.
fn central(members: &[u32], directions: &[Vec3]) -> u32 {
    let along = |&i: &u32| directions[i as usize];
    let mean: Vec3 = members.iter().map(along).sum();
    members.iter().copied().max_by(|a, b| along(a).dot(mean).total_cmp(&along(b).dot(mean))).unwrap_or(0)
}

/// For each eight of `order`, those that touch it: one has a direction that is a neighbour of one of the other.
fn touching(order: &[u32], directions: &[Vec3]) -> Vec<Vec<Touching>> {
    let mut place = vec![0_u32; order.len()];
    order.iter().zip(0..).for_each(|(&direction, at)| place[direction as usize] = at);
    let mut lanes: Vec<BTreeMap<u32, u8>> = vec![BTreeMap::new(); order.len().div_ceil(GROUP)];
    let mut touch = |a: u32, b: u32| {
        let (from, to) = (a / GROUP as u32, b / GROUP as u32);
        if from != to {
            *lanes[from as usize].entry(to).or_default() |= 1 << (a % GROUP as u32);
        }
    };
    for (direction, near) in neighbours(directions).into_iter().enumerate() {
        for other in near {
            let (a, b) = (place[direction], place[other as usize]);
            touch(a, b);
            touch(b, a);
        }
    }
    let list = |of: BTreeMap<u32, u8>| of.into_iter().map(|(group, lanes)| Touching { group, lanes }).collect();
    lanes.into_iter().map(list).collect()
}

/// The [`NEIGHBOURS`] nearest others of each of the directions, if there are as many within some cells of a grid.
fn neighbours(directions: &[Vec3]) -> Vec<Vec<u32>> {
    // The spacing of so many on the sphere, and a little more.
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

/// What is known of a group, before and while it is traced.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    /// Nothing: its block has no probe.
    Nothing,
    /// Its probe meets something.
    Blocked,
    /// Its probe meets nothing.
    Seen,
    Traced,
}

/// Follows the boundaries of origin after origin; keeps its buffers.
#[derive(Default)]
pub struct BoundaryTracer {
    state: State,
    stack: Vec<(u32, u8)>,
    frontier: Frontier,
}

/// What is known of all groups.
#[derive(Default)]
struct State {
    /// Per group, the lanes that are asked for.
    wanted: Vec<u8>,
    /// Per block, what its probe says.
    predicted: Vec<Known>,
    /// Per group.
    known: Vec<Known>,
    /// Per group, the lanes that meet nothing.
    open: Vec<u8>,
    /// Groups to trace.
    front: Vec<u32>,
}

impl BoundaryTracer {
    /// Sets `visible[i]` to 1 for those of the directions within `half` that seem to meet nothing from `origin`. Other entries
    /// are left alone. Returns the number of rays traced.
    ///
    /// `visible` has one entry per direction, in the order in which the set was made.
    pub fn trace(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        set: &BoundarySet,
        half: &HalfSpace,
        visible: &mut [u8],
    ) -> u64 {
        let Self { state, stack, frontier } = self;
        frontier.move_to(scene, origin);
        let rays = Traced { scene, origin, frontier, stack };
        let count = InstructionSet::widest().run(Follow { set, half, rays, state });
        state.show(set, visible);
        count
    }

    /// The same where `open` tells by its bits which of all directions meet nothing: of rays that were traced elsewhere.
    pub fn follow(&mut self, open: &[u32], set: &BoundarySet, half: &HalfSpace, visible: &mut [u8]) {
        InstructionSet::widest().run(Follow { set, half, rays: Told(open), state: &mut self.state });
        self.state.show(set, visible);
    }
}

impl State {
    /// Puts what is between a seen and a blocked block to the front, and what no probe tells of.
    fn start(&mut self, set: &BoundarySet) {
        self.known.clear();
        self.known.extend((0..set.groups.len()).map(|group| self.predicted[group / set.block]));
        self.open.clear();
        for (index, group) in set.groups.iter().enumerate() {
            let (wanted, known) = (self.wanted[index], self.known[index]);
            let differs = |other: &Touching| {
                self.wanted[other.group as usize] != 0 && self.known[other.group as usize] != Known::Seen
            };
            let is_front = match known {
                Known::Nothing => true,
                // Of both sides of a boundary one is enough: it is followed to the other where it runs there.
                Known::Seen => group.touching.iter().any(differs),
                Known::Blocked | Known::Traced => false,
            };
            self.open.push(if known == Known::Seen { wanted } else { 0 });
            if is_front && wanted != 0 {
                self.front.push(index as u32);
            }
        }
    }

    /// Takes what was found in a group, and puts those that touch it and are expected to differ to the front.
    fn found(&mut self, set: &BoundarySet, index: usize, open: u8) {
        (self.open[index], self.known[index]) = (open, Known::Traced);
        for other in &set.groups[index].touching {
            let (lanes, at) = (other.lanes & self.wanted[index], other.group as usize);
            let differs = match self.known[at] {
                Known::Seen => open & lanes != lanes,
                Known::Blocked => open & lanes != 0,
                Known::Nothing | Known::Traced => false,
            };
            if differs && self.wanted[at] != 0 {
                self.front.push(other.group);
            }
        }
    }

    /// Sets `visible` of the lanes that meet nothing.
    fn show(&self, set: &BoundarySet, visible: &mut [u8]) {
        assert_eq!(visible.len(), set.len(), "one visibility a direction");
        for (group, &open) in set.groups.iter().zip(&self.open) {
            let mut rest = open;
            while rest != 0 {
                visible[group.targets[rest.trailing_zeros() as usize] as usize] = 1;
                rest &= rest - 1;
            }
        }
    }
}

/// Tells which rays meet nothing.
trait Rays {
    /// Of the rays `active`, one bit each, those that meet nothing. `targets` are their places in the caller's order.
    fn open<L: Lanes>(&mut self, rays: &RayGroup, targets: &[u32], active: u8) -> u8;
}

/// Traces them.
struct Traced<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    frontier: &'a Frontier,
    stack: &'a mut Vec<(u32, u8)>,
}

impl Rays for Traced<'_> {
    #[inline(always)]
    fn open<L: Lanes>(&mut self, rays: &RayGroup, _: &[u32], active: u8) -> u8 {
        rays.open::<L>(self.scene, self.frontier, self.origin, active, self.stack)
    }
}

/// Was told, by a bit for each direction.
struct Told<'a>(&'a [u32]);

impl Rays for Told<'_> {
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

/// Probes, and follows the boundaries between them. Gives the number of rays asked for.
struct Follow<'a, R> {
    set: &'a BoundarySet,
    half: &'a HalfSpace,
    rays: R,
    state: &'a mut State,
}

impl<R: Rays> Kernel for Follow<'_, R> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        let Self { set, half, mut rays, state } = self;
        let mut count = 0;
        state.wanted.clear();
        for group in &set.groups {
            state.wanted.push(group.rays.within::<L>(half) & lanes_below(group.targets.len()));
        }
        state.predicted.clear();
        for probes in &set.probes {
            let active = probes.rays.within::<L>(half) & lanes_below(probes.targets.len());
            count += u64::from(active.count_ones());
            let open = if active == 0 { 0 } else { rays.open::<L>(&probes.rays, &probes.targets, active) };
            for lane in 0..probes.targets.len() {
                let known = if open >> lane & 1 == 1 { Known::Seen } else { Known::Blocked };
                state.predicted.push(if active >> lane & 1 == 1 { known } else { Known::Nothing });
            }
        }
        state.start(set);
        while let Some(index) = state.front.pop() {
            let index = index as usize;
            if state.known[index] != Known::Traced {
                let (group, wanted) = (&set.groups[index], state.wanted[index]);
                count += u64::from(wanted.count_ones());
                let open = rays.open::<L>(&group.rays, &group.targets, wanted);
                state.found(set, index, open);
            }
        }
        count
    }
}
