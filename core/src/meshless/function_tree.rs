//! The function that stands for a place: the first leaf of a balanced kd-tree that faces the same way (meshless radiosity, 5.1).
//!
//! The tree is over positions and normals, so that leaves at an edge face the way of their side. Its axes are turned: along those of
//! the world, whole walls have one coordinate, which no split can tell apart. Functions of an owner lie one after another, as the
//! median splits order them, and the tree has no nodes: a range of functions is split in its middle.

use super::object_bases::{ObjectBases, Owner};
use crate::surfel::Surfel;
use glam::Vec3;
use std::{collections::HashMap, ops::Range};

/// Least cosine between the normals of a place and of the function that stands for it.
const LEAST_COSINE: f32 = 0.5;
/// Leaves that are tried after the first.
const FURTHER_LEAVES: usize = 4;
/// Dimensions of position and normal.
const AXES: usize = 6;

/// A place in the space of the tree.
type Place = [f32; AXES];

/// A function: its number, place, position and normal.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    function: u32,
    place: Place,
    position: Vec3,
    normal: Vec3,
}

/// Where a range is split in its middle.
#[derive(Clone, Copy, Debug, Default)]
struct Split {
    axis: u32,
    value: f32,
}

/// Trees over the functions that send light, one for each owner.
#[derive(Clone, Debug)]
pub struct FunctionTree {
    leaves: Vec<Leaf>,
    /// The split of the range whose middle it is.
    splits: Vec<Split>,
    owners: HashMap<Owner, Range<u32>>,
    axes: [Place; AXES],
    /// Length in meters of a normal.
    reach: f32,
}

impl FunctionTree {
    /// Trees over the functions of the level that sends.
    pub fn new(bases: &ObjectBases) -> Self {
        let senders = bases.level(bases.sender_level());
        let (axes, reach) = (turned_axes(), bases.radii()[bases.sender_level()]);
        let leaf = |i: usize| {
            let at = &bases.points()[i];
            let place = place(&axes, reach, at);
            (bases.owners()[i], Leaf { function: i as u32, place, position: at.position, normal: at.normal })
        };
        let mut leaves: Vec<(Owner, Leaf)> = senders.map(leaf).collect();
        leaves.sort_by_key(|(owner, leaf)| (*owner, leaf.function));
        let (mut owners, mut start) = (HashMap::new(), 0);
        for of_owner in leaves.chunk_by(|a, b| a.0 == b.0) {
            owners.insert(of_owner[0].0, start..start + of_owner.len() as u32);
            start += of_owner.len() as u32;
        }
        let leaves: Vec<Leaf> = leaves.into_iter().map(|(_, leaf)| leaf).collect();
        let mut tree = Self { splits: vec![Split::default(); leaves.len()], leaves, owners, axes, reach };
        let ranges: Vec<Range<u32>> = tree.owners.values().cloned().collect();
        ranges.into_iter().for_each(|range| tree.split(range.start as usize..range.end as usize));
        tree
    }

    /// Orders the leaves of a range by median splits along its longest side.
    fn split(&mut self, range: Range<usize>) {
        if range.len() < 2 {
            return;
        }
        let leaves = &mut self.leaves[range.clone()];
        let extent = |axis: usize| {
            let ends = leaves.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), leaf| {
                (low.min(leaf.place[axis]), high.max(leaf.place[axis]))
            });
            ends.1 - ends.0
        };
        let axis = (0..AXES).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        let half = leaves.len() / 2;
        // Equal places are ordered by number, so that the order is the same everywhere.
        leaves.select_nth_unstable_by(half, |a, b| {
            a.place[axis].total_cmp(&b.place[axis]).then(a.function.cmp(&b.function))
        });
        let middle = range.start + half;
        self.splits[middle] = Split { axis: axis as u32, value: self.leaves[middle].place[axis] };
        self.split(range.start..middle);
        self.split(middle..range.end);
    }

    /// The function that stands for a point as baked; `None` if its owner has none.
    pub fn find(&self, owner: Owner, at: &Surfel) -> Option<u32> {
        let range = self.owners.get(&owner)?;
        let place = place(&self.axes, self.reach, at);
        let (mut others, mut nearest) = (Others::default(), (f32::INFINITY, None));
        let mut next = Some(range.start..range.end);
        for _ in 0..=FURTHER_LEAVES {
            let Some(range) = next else { break };
            let leaf = &self.leaves[self.leaf_of(range, &place, &mut others)];
            if leaf.normal.dot(at.normal) > LEAST_COSINE {
                return Some(leaf.function);
            }
            let distance = leaf.position.distance_squared(at.position);
            if distance < nearest.0 {
                nearest = (distance, Some(leaf.function));
            }
            next = others.pop();
        }
        nearest.1
    }

    /// The leaf of a range on the side of a place; the sides that are left out are kept.
    fn leaf_of(&self, mut range: Range<u32>, place: &Place, others: &mut Others) -> usize {
        while range.len() > 1 {
            let middle = range.start + range.len() as u32 / 2;
            let Split { axis, value } = self.splits[middle as usize];
            let (below, above) = (range.start..middle, middle..range.end);
            let (near, far) = if place[axis as usize] < value { (below, above) } else { (above, below) };
            others.push(far);
            range = near;
        }
        range.start as usize
    }
}

/// The place of a surface point: its position and its normal, as long as the reach of a function, along the turned axes.
#[inline]
fn place(axes: &[Place; AXES], reach: f32, at: &Surfel) -> Place {
    let (p, n) = (at.position, at.normal * reach);
    let all = [p.x, p.y, p.z, n.x, n.y, n.z];
    axes.map(|axis| axis.iter().zip(all).map(|(a, x)| a * x).sum())
}

/// Perpendicular unit vectors that are aligned to nothing.
fn turned_axes() -> [Place; AXES] {
    let dot = |a: &Place, b: &Place| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
    let mut random = fastrand::Rng::with_seed(1);
    let mut axes = [[0.0; AXES]; AXES];
    for i in 0..AXES {
        let mut axis: Place = std::array::from_fn(|_| random.f32() - 0.5);
        for earlier in &axes[..i] {
            let along = dot(&axis, earlier);
            axis.iter_mut().zip(earlier).for_each(|(a, e)| *a -= along * e);
        }
        let length = dot(&axis, &axis).sqrt();
        axes[i] = axis.map(|a| a / length);
    }
    axes
}

/// Ranges that a search has left out, the last first. A tree of all functions is less deep than this.
#[derive(Default)]
struct Others {
    ranges: [(u32, u32); 32],
    count: usize,
}

impl Others {
    fn push(&mut self, range: Range<u32>) {
        self.ranges[self.count] = (range.start, range.end);
        self.count += 1;
    }

    fn pop(&mut self) -> Option<Range<u32>> {
        self.count = self.count.checked_sub(1)?;
        let (start, end) = self.ranges[self.count];
        Some(start..end)
    }
}
