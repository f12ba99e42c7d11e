//! Adjacency of groups of eight, and of blocks of groups.

use crate::ray::directions::GROUP;
use std::collections::BTreeMap;

/// Members in groups of eight nearby ones, and in blocks of groups. A member is a direction or a point.
#[derive(Clone)]
pub(super) struct Graph {
    pub groups: Vec<Group>,
    /// Groups per block.
    pub block: usize,
    /// Number of members.
    pub len: usize,
}

/// Eight nearby members; fewer in the last group.
#[derive(Clone)]
pub(super) struct Group {
    /// Position of each in the caller's order.
    pub targets: Vec<u32>,
    /// Groups that touch this one.
    pub touching: Vec<Touching>,
}

/// A group that touches another.
#[derive(Clone)]
pub(super) struct Touching {
    pub group: u32,
    /// Lanes of this group with a neighbor in the other one.
    pub lanes: u8,
}

impl Graph {
    /// A graph of members in `order`, where each run of eight lies close together. `neighbours` has a list for each
    /// member, in the caller's order. A block has `members_per_probe` of them.
    pub fn new(order: &[u32], neighbours: &[Vec<u32>], members_per_probe: usize) -> Self {
        assert!(
            members_per_probe > 1 && super::is_number_per_probe(members_per_probe),
            "{members_per_probe} for each probe"
        );
        let groups = order.chunks(GROUP).zip(touching(order, neighbours));
        let group = |(members, touching): (&[u32], _)| Group { targets: members.to_vec(), touching };
        Self { groups: groups.map(group).collect(), block: members_per_probe / GROUP, len: order.len() }
    }
}

/// For each eight of `order`, the touching ones: a member of one is a neighbor of a member of the other.
fn touching(order: &[u32], neighbours: &[Vec<u32>]) -> Vec<Vec<Touching>> {
    let mut place = vec![0_u32; order.len()];
    order.iter().zip(0..).for_each(|(&member, at)| place[member as usize] = at);
    let mut lanes: Vec<BTreeMap<u32, u8>> = vec![BTreeMap::new(); order.len().div_ceil(GROUP)];
    let mut touch = |a: u32, b: u32| {
        let (from, to) = (a / GROUP as u32, b / GROUP as u32);
        if from != to {
            *lanes[from as usize].entry(to).or_default() |= 1 << (a % GROUP as u32);
        }
    };
    for (member, near) in neighbours.iter().enumerate() {
        for &other in near {
            let (a, b) = (place[member], place[other as usize]);
            touch(a, b);
            touch(b, a);
        }
    }
    let list = |of: BTreeMap<u32, u8>| of.into_iter().map(|(group, lanes)| Touching { group, lanes }).collect();
    lanes.into_iter().map(list).collect()
}
