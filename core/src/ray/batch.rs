//! Occlusion of a whole direction set from one origin.
//!
//! A packet walks the box hierarchy once for its 64 rays. A box is dropped if a bounding plane of the packet or of a group of
//! eight excludes it, or if no ray of the group enters it. Where triangles are small compared to the distance between rays, most
//! boxes lie between rays. Leaves are tested eight triangles and eight rays at a time. The box tests drop only boxes that no ray
//! enters, so the result equals tracing each ray alone. The walk is a [`Kernel`], for the widest instructions of the machine.

use super::{
    DirectionSet, Intersector, OPEN,
    directions::{GROUP, GROUPS, PACKET, PACKET_PLANES, Packet},
    leaves::BlockFrom,
};
use crate::simd::{InstructionSet, Kernel, Lanes, Vec3x8};
use glam::Vec3;
use obvhs::bvh2::node::Bvh2Node;

/// Active rays of a packet: eight bits per group.
pub(super) type Active = [u8; GROUPS];

impl Intersector {
    /// Traces all directions for which `wanted` holds from `origin`, and sets `visible[i]` of unblocked ones to
    /// [`OPEN`]. Other entries stay unchanged. Returns the number of rays traced.
    ///
    /// `wanted` gets an index and a direction; it must be cheap. `visible` has one entry per direction, in the order of the set's creation.
    pub fn trace_batch(
        &self,
        origin: Vec3,
        directions: &DirectionSet,
        wanted: impl Fn(u32, Vec3) -> bool,
        visible: &mut [u8],
    ) -> u64 {
        assert_eq!(visible.len(), directions.len(), "one visibility a direction");
        let mut stack = Vec::with_capacity(128);
        let (mut traced, set) = (0, InstructionSet::widest());
        for packet in &directions.packets {
            let active = wanted_rays(packet, &wanted);
            let count: u32 = active.iter().map(|a| a.count_ones()).sum();
            if count == 0 {
                continue;
            }
            traced += u64::from(count);
            let open = set.run(Walk::<false> { scene: self, packet, origin, active, stack: &mut stack });
            for i in 0..packet.count {
                if open[i / GROUP] >> (i % GROUP) & 1 == 1 {
                    visible[packet.targets[i] as usize] = OPEN;
                }
            }
        }
        traced
    }
}

fn wanted_rays(packet: &Packet, wanted: &impl Fn(u32, Vec3) -> bool) -> Active {
    let mut active = [0; GROUPS];
    for i in 0..packet.count {
        active[i / GROUP] |= u8::from(wanted(packet.targets[i], packet.rays[i / GROUP].lane(i % GROUP))) << (i % GROUP);
    }
    active
}

/// Walks the hierarchy for a packet of rays or, if `SEGMENTS`, of segments with ends `origin + ray`, beyond which
/// nothing counts. Returns the unblocked rays of `active`.
pub(super) struct Walk<'a, const SEGMENTS: bool> {
    pub scene: &'a Intersector,
    pub packet: &'a Packet,
    pub origin: Vec3,
    pub active: Active,
    /// Nodes to visit, with the groups that may enter them.
    pub stack: &'a mut Vec<(u32, u8)>,
}

impl<const SEGMENTS: bool> Kernel for Walk<'_, SEGMENTS> {
    type Output = Active;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Active {
        let Self { scene, packet, origin, mut active, stack } = self;
        let nodes = &scene.bvh.nodes[..];
        if nodes.is_empty() {
            return active;
        }
        let mut live = live_groups(&active);
        stack.clear();
        stack.push((0, u8::MAX));
        while let Some((index, groups)) = stack.pop() {
            let node = &nodes[index as usize];
            let groups = reached_groups::<SEGMENTS, L>(packet, origin, node, groups & live, &active);
            if groups == 0 {
                continue;
            }
            if node.prim_count > 0 {
                for corners in scene.blocks.of_leaf(node.first_index, node.prim_count) {
                    block::<SEGMENTS, L>(packet, &BlockFrom::new(origin, corners), groups, &mut active);
                }
                live = live_groups(&active);
                if live == 0 {
                    break;
                }
            } else {
                let near = nearer_child(nodes, node.first_index, packet.axis);
                stack.push((node.first_index + 1 - near, groups));
                stack.push((node.first_index + near, groups));
            }
        }
        active
    }
}

/// 0 or 1: which of two adjacent nodes comes first along `axis`.
#[inline(always)]
pub(super) fn nearer_child(nodes: &[Bvh2Node], first: u32, axis: Vec3) -> u32 {
    let along = |n: &Bvh2Node| (Vec3::from(n.aabb.min) + Vec3::from(n.aabb.max)).dot(axis);
    u32::from(along(&nodes[first as usize + 1]) < along(&nodes[first as usize]))
}

/// Groups with at least one active ray, one bit each.
#[inline(always)]
fn live_groups(active: &Active) -> u8 {
    (0..GROUPS).fold(0, |mask, g| mask | u8::from(active[g] != 0) << g)
}

/// The subset of `groups` with an active ray that may enter the node's box.
#[inline(always)]
fn reached_groups<const SEGMENTS: bool, L: Lanes>(
    packet: &Packet,
    origin: Vec3,
    node: &Bvh2Node,
    groups: u8,
    active: &Active,
) -> u8 {
    let (min, max) = (Vec3::from(node.aabb.min) - origin, Vec3::from(node.aabb.max) - origin);
    let center = Vec3x8::<L>::splat(0.5 * (min + max));
    let half = Vec3x8::splat(0.5 * (max - min));
    if groups == 0 || beyond(&packet.planes, center, half) != 0 {
        return 0;
    }
    let mut outside = 0;
    for planes in &packet.group_planes {
        outside |= beyond(planes, center, half);
    }
    entered_groups::<SEGMENTS, L>(packet, min, max, groups & !outside, active)
}

/// The subset of `groups` with an active ray that enters the box, ray by ray.
#[inline(always)]
fn entered_groups<const SEGMENTS: bool, L: Lanes>(
    packet: &Packet,
    min: Vec3,
    max: Vec3,
    groups: u8,
    active: &Active,
) -> u8 {
    let (min, max) = (Vec3x8::<L>::splat(min), Vec3x8::splat(max));
    let (mut rest, mut entered) = (groups, 0);
    while rest != 0 {
        let g = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        let entry = entry_and_exit(Vec3x8::load(&packet.inverse_rays[g]), min, max);
        entered |= u8::from(entering::<SEGMENTS, L>(entry) & active[g] != 0) << g;
    }
    entered
}

/// Entry and exit of eight rays into a box, in ray lengths: the slab test. A ray whose exit comes before its entry misses.
#[inline(always)]
pub(super) fn entry_and_exit<L: Lanes>(inverse: Vec3x8<L>, min: Vec3x8<L>, max: Vec3x8<L>) -> (L, L) {
    let (a, b) = (min.scale(inverse), max.scale(inverse));
    let near = (a.x.fast_min(b.x)).fast_max(a.y.fast_min(b.y)).fast_max(a.z.fast_min(b.z));
    let far = (a.x.fast_max(b.x)).fast_min(a.y.fast_max(b.y)).fast_min(a.z.fast_max(b.z));
    (near.fast_max(L::splat(0.0)), far)
}

/// Mask of eight rays that enter the box, with a margin above the rounding of the slab test.
#[inline(always)]
pub(super) fn entering<const SEGMENTS: bool, L: Lanes>((entry, exit): (L, L)) -> u8 {
    let margin = L::splat(1.0 + 1e-6);
    let entered = entry.simd_le(exit * margin);
    // The parameter along a segment is 1 at its end.
    (if SEGMENTS { entered & entry.simd_le(margin) } else { entered }).to_bitmask() as u8
}

/// Bit `i` is set if the box lies wholly on the outer side of plane `i` through the origin.
#[inline(always)]
fn beyond<L: Lanes>(planes: &Vec3x8, center: Vec3x8<L>, half: Vec3x8<L>) -> u8 {
    let planes: Vec3x8<L> = Vec3x8::load(planes);
    let extent = planes.x.abs() * half.x + planes.y.abs() * half.y + planes.z.abs() * half.z;
    (planes.dot(center) - extent).simd_gt(L::splat(0.0)).to_bitmask() as u8
}

/// Deactivates the rays of `groups` that cross any of eight triangles.
#[inline(always)]
fn block<const SEGMENTS: bool, L: Lanes>(packet: &Packet, triangles: &BlockFrom<L>, groups: u8, active: &mut Active) {
    let mut near = triangles.near_cone(Vec3x8::splat(packet.axis), L::splat(packet.sin_sq));
    while near != 0 {
        let lane = near.trailing_zeros() as usize;
        let edges = triangles.edges_of(lane);
        let plane = triangles.plane_of(lane);
        near &= near - 1;
        let mut rest = groups;
        while rest != 0 {
            let g = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let rays = Vec3x8::load(&packet.rays[g]);
            let mut crossed = crossings(rays, &edges);
            if SEGMENTS {
                crossed &= passing(rays, &plane);
            }
            active[g] &= !crossed;
        }
    }
}

/// Mask of eight rays that cross the triangle, by the arithmetic of [`super::triangle::TriangleFrom::crosses`].
#[inline(always)]
pub(super) fn crossings<L: Lanes>(rays: Vec3x8<L>, edges: &[Vec3x8<L>; 3]) -> u8 {
    let zero = L::splat(0.0);
    let [a, b, c] = [edges[0].dot(rays), edges[1].dot(rays), edges[2].dot(rays)];
    (a.simd_ge(zero) & b.simd_ge(zero) & c.simd_ge(zero)).to_bitmask() as u8
}

/// Mask of eight segments that end beyond a plane, by the arithmetic of [`super::triangle::TriangleFrom::crosses_before`].
#[inline(always)]
pub(super) fn passing<L: Lanes>(segments: Vec3x8<L>, plane: &(Vec3x8<L>, L)) -> u8 {
    plane.0.dot(segments).simd_gt(plane.1).to_bitmask() as u8
}

const _: () = assert!(PACKET <= 64 && PACKET_PLANES == 8 && GROUPS == 8);
