//! Occlusion of a whole direction set from one origin.
//!
//! A packet walks the box hierarchy once for its 64 rays. A box is dropped if one bounding plane of the packet, or for
//! each group of eight one of the group's own, has it wholly outside, or if no ray of the group enters it: where triangles
//! are small against the distance between rays, most boxes slip between. Leaves are tested eight triangles and eight rays
//! at a time.
//! The box tests only ever drop boxes that no ray enters, so the result is that of tracing each ray alone.
//! Vectors of eight are two of 128 bits; the loop is compiled for several instruction sets, chosen at run time.

use super::{
    DirectionSet, Intersector,
    directions::{GROUP, GROUP_PLANES, GROUPS, PACKET, PACKET_PLANES, Packet},
    leaves::BlockFrom,
};
use crate::simd::Vec3x8;
use glam::Vec3;
use multiversion::multiversion;
use obvhs::bvh2::node::Bvh2Node;
use wide::f32x8;

/// Which rays of a packet are still under way: eight bits a group.
pub(super) type Active = [u8; GROUPS];

impl Intersector {
    /// Traces all directions for which `wanted` holds from `origin`, and sets `visible[i]` of those that meet nothing
    /// to 1. Other entries are left alone. Returns the number of rays traced.
    ///
    /// `wanted` gets a direction; it must be cheap. `visible` has one entry per direction, in the order in which the
    /// set was made.
    pub fn trace_batch(
        &self,
        origin: Vec3,
        directions: &DirectionSet,
        wanted: impl Fn(Vec3) -> bool,
        visible: &mut [u8],
    ) -> u64 {
        assert_eq!(visible.len(), directions.len(), "one visibility a direction");
        let mut stack = Vec::with_capacity(128);
        let mut traced = 0;
        for packet in &directions.packets {
            let active = wanted_rays(packet, &wanted);
            let count: u32 = active.iter().map(|a| a.count_ones()).sum();
            if count == 0 {
                continue;
            }
            traced += u64::from(count);
            let open = trace_packet(self, packet, origin, active, &mut stack);
            for i in 0..packet.count {
                if open[i / GROUP] >> (i % GROUP) & 1 == 1 {
                    visible[packet.targets[i] as usize] = 1;
                }
            }
        }
        traced
    }
}

fn wanted_rays(packet: &Packet, wanted: &impl Fn(Vec3) -> bool) -> Active {
    let mut active = [0; GROUPS];
    for i in 0..packet.count {
        active[i / GROUP] |= u8::from(wanted(packet.rays[i / GROUP].lane(i % GROUP))) << (i % GROUP);
    }
    active
}

/// The rays of `active` that meet nothing.
#[multiversion(targets("x86_64+avx2", "x86_64+sse4.2", "aarch64+neon"))]
fn trace_packet(
    scene: &Intersector,
    packet: &Packet,
    origin: Vec3,
    active: Active,
    stack: &mut Vec<(u32, u8)>,
) -> Active {
    walk::<false>(scene, packet, origin, active, stack)
}

/// The same for a packet of segments: what lies beyond their ends does not count.
#[multiversion(targets("x86_64+avx2", "x86_64+sse4.2", "aarch64+neon"))]
pub(super) fn trace_segments(
    scene: &Intersector,
    packet: &Packet,
    origin: Vec3,
    active: Active,
    stack: &mut Vec<(u32, u8)>,
) -> Active {
    walk::<true>(scene, packet, origin, active, stack)
}

/// Walks the hierarchy for a packet of rays or, if `SEGMENTS`, of segments whose ends are `origin + ray`.
#[inline(always)]
fn walk<const SEGMENTS: bool>(
    scene: &Intersector,
    packet: &Packet,
    origin: Vec3,
    mut active: Active,
    stack: &mut Vec<(u32, u8)>,
) -> Active {
    let nodes = &scene.bvh.nodes[..];
    if nodes.is_empty() {
        return active;
    }
    let mut live = live_groups(&active);
    stack.clear();
    stack.push((0, u8::MAX));
    while let Some((index, groups)) = stack.pop() {
        let node = &nodes[index as usize];
        let groups = reached_groups::<SEGMENTS>(packet, origin, node, groups & live, &active);
        if groups == 0 {
            continue;
        }
        if node.prim_count > 0 {
            for corners in scene.blocks.of_leaf(node.first_index, node.prim_count) {
                block::<SEGMENTS>(packet, &BlockFrom::new(origin, corners), groups, &mut active);
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

/// 0 or 1: which of two adjacent nodes comes first along `axis`.
#[inline(always)]
fn nearer_child(nodes: &[Bvh2Node], first: u32, axis: Vec3) -> u32 {
    let along = |n: &Bvh2Node| (Vec3::from(n.aabb.min) + Vec3::from(n.aabb.max)).dot(axis);
    u32::from(along(&nodes[first as usize + 1]) < along(&nodes[first as usize]))
}

/// Groups with at least one ray under way, one bit each.
#[inline(always)]
fn live_groups(active: &Active) -> u8 {
    (0..GROUPS).fold(0, |mask, g| mask | u8::from(active[g] != 0) << g)
}

/// Which of `groups` have an active ray that may enter the node's box.
#[inline(always)]
fn reached_groups<const SEGMENTS: bool>(
    packet: &Packet,
    origin: Vec3,
    node: &Bvh2Node,
    groups: u8,
    active: &Active,
) -> u8 {
    let (min, max) = (Vec3::from(node.aabb.min) - origin, Vec3::from(node.aabb.max) - origin);
    let center = Vec3x8::splat(0.5 * (min + max));
    let half = Vec3x8::splat(0.5 * (max - min));
    if groups == 0 || beyond(&packet.planes, center, half) != 0 {
        return 0;
    }
    let outside = (0..GROUP_PLANES).fold(0, |outside, k| outside | beyond(&packet.group_planes[k], center, half));
    let reached = groups & !outside;
    entered_groups::<SEGMENTS>(packet, min, max, reached, active)
}

/// Which of `groups` have an active ray that enters the box, ray by ray.
#[inline(always)]
fn entered_groups<const SEGMENTS: bool>(packet: &Packet, min: Vec3, max: Vec3, groups: u8, active: &Active) -> u8 {
    let (min, max) = (Vec3x8::splat(min), Vec3x8::splat(max));
    let (mut rest, mut entered) = (groups, 0);
    while rest != 0 {
        let g = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        entered |= u8::from(entering::<SEGMENTS>(&packet.inverse_rays[g], min, max) & active[g] != 0) << g;
    }
    entered
}

/// Which of eight rays enter the box, one bit each: the slab test, with a margin above its rounding.
#[inline(always)]
fn entering<const SEGMENTS: bool>(inverse: &Vec3x8, min: Vec3x8, max: Vec3x8) -> u8 {
    let (near, far) = (min.scale(*inverse), max.scale(*inverse));
    let lower = |a: f32x8, b: f32x8| a.fast_min(b);
    let upper = |a: f32x8, b: f32x8| a.fast_max(b);
    let entry = upper(upper(lower(near.x, far.x), lower(near.y, far.y)), lower(near.z, far.z)).fast_max(f32x8::ZERO);
    let exit = lower(lower(upper(near.x, far.x), upper(near.y, far.y)), upper(near.z, far.z));
    let margin = f32x8::splat(1.0 + 1e-6);
    let entered = entry.simd_le(exit * margin);
    // The parameter along a segment is 1 at its end.
    (if SEGMENTS { entered & entry.simd_le(margin) } else { entered }).to_bitmask() as u8
}

/// Bit `i` is set if the box lies wholly on the outer side of plane `i` through the origin.
#[inline(always)]
fn beyond(planes: &Vec3x8, center: Vec3x8, half: Vec3x8) -> u8 {
    let extent = planes.x.abs() * half.x + planes.y.abs() * half.y + planes.z.abs() * half.z;
    (planes.dot(center) - extent).simd_gt(f32x8::ZERO).to_bitmask() as u8
}

/// Ends the rays of `groups` that cross any of eight triangles.
#[inline(always)]
fn block<const SEGMENTS: bool>(packet: &Packet, triangles: &BlockFrom, groups: u8, active: &mut Active) {
    let mut near = triangles.near_cone(Vec3x8::splat(packet.axis), f32x8::splat(packet.sin_sq));
    while near != 0 {
        let lane = near.trailing_zeros() as usize;
        let edges = triangles.edges_of(lane);
        let plane = triangles.plane_of(lane);
        near &= near - 1;
        let mut rest = groups;
        while rest != 0 {
            let g = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let mut crossed = crossings(&packet.rays[g], &edges);
            if SEGMENTS {
                crossed &= passing(&packet.rays[g], &plane);
            }
            active[g] &= !crossed;
        }
    }
}

/// Which of eight rays cross the triangle, one bit each; the same arithmetic as [`super::triangle::TriangleFrom::crosses`].
#[inline(always)]
fn crossings(rays: &Vec3x8, edges: &[Vec3x8; 3]) -> u8 {
    let inside = |edge: &Vec3x8| edge.dot(*rays).simd_ge(f32x8::ZERO);
    (inside(&edges[0]) & inside(&edges[1]) & inside(&edges[2])).to_bitmask() as u8
}

/// Which of eight segments end beyond a plane, one bit each; the same arithmetic as
/// [`super::triangle::TriangleFrom::crosses_before`].
#[inline(always)]
fn passing(segments: &Vec3x8, plane: &(Vec3x8, f32x8)) -> u8 {
    plane.0.dot(*segments).simd_gt(plane.1).to_bitmask() as u8
}

const _: () = assert!(PACKET <= 64 && PACKET_PLANES == 8 && GROUPS == 8);
