//! Occlusion of a whole direction set from one origin.
//!
//! A packet walks the box hierarchy once for its 64 rays. A box is dropped if one bounding plane of the packet, or for
//! each group of eight one of the group's own, has it wholly outside; what remains is tested eight rays at a time.
//! The box tests only ever drop boxes that no ray enters, so the result is that of tracing each ray alone.
//! Loops run over arrays of eight and are compiled for several instruction sets, chosen at run time.

use super::{
    DirectionSet, Intersector,
    directions::{GROUP, GROUP_PLANES, GROUPS, PACKET, PACKET_PLANES, Packet, Vec3Lanes},
    triangle::TriangleFrom,
};
use glam::Vec3;
use multiversion::multiversion;
use obvhs::bvh2::node::Bvh2Node;

/// Which rays of a packet are still under way: eight bits a group.
type Active = [u8; GROUPS];

impl Intersector {
    /// Traces all directions for which `wanted` holds from `origin`, and sets `visible[i]` of those that meet nothing
    /// to 1. Other entries are left alone. Returns the number of rays traced.
    ///
    /// `wanted` gets a direction; it must be cheap. `visible` has one entry a direction, in the order in which the
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
        active[i / GROUP] |= u8::from(wanted(packet.rays[i / GROUP].get(i % GROUP))) << (i % GROUP);
    }
    active
}

/// The rays of `active` that meet nothing.
#[multiversion(targets("x86_64+avx2", "x86_64+sse4.2", "aarch64+neon"))]
fn trace_packet(
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
        let groups = reached_groups(packet, origin, node, groups & live);
        if groups == 0 {
            continue;
        }
        if node.prim_count > 0 {
            let first = node.first_index as usize;
            for &corners in &scene.leaf_triangles[first..first + node.prim_count as usize] {
                block(packet, &TriangleFrom::new(origin, corners), groups, &mut active);
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

/// Which of `groups` may enter the node's box.
#[inline(always)]
fn reached_groups(packet: &Packet, origin: Vec3, node: &Bvh2Node, groups: u8) -> u8 {
    let (min, max) = (Vec3::from(node.aabb.min) - origin, Vec3::from(node.aabb.max) - origin);
    let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
    if groups == 0 || beyond(&packet.planes, center, half) != [0; PACKET_PLANES] {
        return 0;
    }
    let mut outside = [0_u32; 8];
    for k in 0..GROUP_PLANES {
        let past = beyond(&packet.group_planes[k], center, half);
        for g in 0..8 {
            outside[g] |= past[g];
        }
    }
    groups & !bits(&outside)
}

/// For each of eight planes through the origin: 1 if the box lies wholly on its outer side.
#[inline(always)]
fn beyond(planes: &Vec3Lanes, center: Vec3, half: Vec3) -> [u32; 8] {
    std::array::from_fn(|i| {
        let (x, y, z) = (planes.x[i], planes.y[i], planes.z[i]);
        let nearest = x * center.x + y * center.y + z * center.z
            - (x.abs() * half.x + y.abs() * half.y + z.abs() * half.z);
        u32::from(nearest > 0.0)
    })
}

#[inline(always)]
fn bits(flags: &[u32; 8]) -> u8 {
    (0..8).fold(0, |mask, i| mask | (flags[i] as u8) << i)
}

/// Ends the rays of `groups` that cross the triangle.
#[inline(always)]
fn block(packet: &Packet, triangle: &TriangleFrom, groups: u8, active: &mut Active) {
    if triangle.side == 0.0 {
        return;
    }
    let mut rest = groups;
    while rest != 0 {
        let g = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        active[g] &= !crossings(&packet.rays[g], triangle);
    }
}

/// Which of eight rays cross the triangle, one bit each; the same arithmetic as [`TriangleFrom::crosses`].
#[inline(always)]
fn crossings(rays: &Vec3Lanes, triangle: &TriangleFrom) -> u8 {
    let [a, b, c] = triangle.edges;
    let inside: [u32; 8] = std::array::from_fn(|i| {
        let (x, y, z) = (rays.x[i], rays.y[i], rays.z[i]);
        let da = a.x * x + a.y * y + a.z * z;
        let db = b.x * x + b.y * y + b.z * z;
        let dc = c.x * x + c.y * y + c.z * z;
        u32::from(da >= 0.0) & u32::from(db >= 0.0) & u32::from(dc >= 0.0)
    });
    bits(&inside)
}

const _: () = assert!(PACKET <= 64 && PACKET_PLANES == 8 && GROUPS == 8);
