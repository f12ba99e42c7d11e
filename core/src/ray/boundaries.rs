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
    probes: Vec<RayGroup>,
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

/// A group that touches another.
struct Touching {
    group: u32,
    /// Lanes of that other one that have a neighbour in it.
    lanes: u8,
}

impl BoundarySet {
    /// One probe in each block of `directions_per_probe` of the unit `directions`; a multiple of eight.
    pub fn new(directions: &[Vec3], directions_per_probe: usize) -> Self {
        assert!(directions_per_probe > 0 && directions_per_probe.is_multiple_of(GROUP), "{directions_per_probe}");
        let order = spatial_order(directions);
        let of = |members: &[u32]| -> Vec<Vec3> { members.iter().map(|&i| directions[i as usize]).collect() };
        let groups = order.chunks(GROUP).zip(touching(&order, directions)).map(|(members, touching)| Group {
            rays: RayGroup::new(&of(members)),
            targets: members.to_vec(),
            touching,
        });
        let probes: Vec<Vec3> = order.chunks(directions_per_probe).map(|block| central(&of(block))).collect();
        Self {
            groups: groups.collect(),
            probes: probes.chunks(GROUP).map(RayGroup::new).collect(),
            block: directions_per_probe / GROUP,
            len: directions.len(),
        }
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Probes of the group of probes.
    fn probes_in(&self, group: usize) -> usize {
        (self.groups.len().div_ceil(self.block) - GROUP * group).min(GROUP)
    }
}

/// That of the directions which is nearest to their mean.
fn central(directions: &[Vec3]) -> Vec3 {
    let mean: Vec3 = directions.iter().sum();
    directions.iter().copied().max_by(|a, b| a.dot(mean).total_cmp(&b.dot(mean))).unwrap_or(Vec3::Y)
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

/// Traces origin after origin; keeps its buffers.
#[derive(Default)]
pub struct BoundaryTracer {
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
    stack: Vec<(u32, u8)>,
    frontier: Frontier,
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
        assert_eq!(visible.len(), set.len(), "one visibility a direction");
        self.frontier.move_to(scene, origin);
        let rays = InstructionSet::widest().run(Follow { scene, origin, set, half, tracer: self });
        for (group, &open) in set.groups.iter().zip(&self.open) {
            let mut rest = open;
            while rest != 0 {
                visible[group.targets[rest.trailing_zeros() as usize] as usize] = 1;
                rest &= rest - 1;
            }
        }
        rays
    }

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
}

/// The first `count` of eight lanes.
fn lanes_below(count: usize) -> u8 {
    ((1_u32 << count) - 1) as u8
}

/// Probes, and follows the boundaries between them. Gives the rays traced.
struct Follow<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    set: &'a BoundarySet,
    half: &'a HalfSpace,
    tracer: &'a mut BoundaryTracer,
}

impl Kernel for Follow<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        let Self { scene, origin, set, half, tracer } = self;
        let mut rays = 0;
        tracer.wanted.clear();
        for group in &set.groups {
            tracer.wanted.push(group.rays.within::<L>(half) & lanes_below(group.targets.len()));
        }
        tracer.predicted.clear();
        for (index, probes) in set.probes.iter().enumerate() {
            let active = probes.within::<L>(half) & lanes_below(set.probes_in(index));
            rays += u64::from(active.count_ones());
            let open = if active == 0 {
                0
            } else {
                probes.open::<L>(scene, &tracer.frontier, origin, active, &mut tracer.stack)
            };
            for lane in 0..GROUP {
                let known = if open >> lane & 1 == 1 { Known::Seen } else { Known::Blocked };
                tracer.predicted.push(if active >> lane & 1 == 1 { known } else { Known::Nothing });
            }
        }
        tracer.start(set);
        while let Some(index) = tracer.front.pop() {
            let (index, group) = (index as usize, &set.groups[index as usize]);
            if tracer.known[index] == Known::Traced {
                continue;
            }
            let wanted = tracer.wanted[index];
            rays += u64::from(wanted.count_ones());
            let open = group.rays.open::<L>(scene, &tracer.frontier, origin, wanted, &mut tracer.stack);
            (tracer.open[index], tracer.known[index]) = (open, Known::Traced);
            for other in &group.touching {
                let (lanes, at) = (other.lanes & wanted, other.group as usize);
                let differs = match tracer.known[at] {
                    Known::Seen => open & lanes != lanes,
                    Known::Blocked => open & lanes != 0,
                    Known::Nothing | Known::Traced => false,
                };
                if differs && tracer.wanted[at] != 0 {
                    tracer.front.push(other.group);
                }
            }
        }
        rays
    }
}
