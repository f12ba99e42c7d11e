//! Visibility of many points from one: batches of segments with a common origin.
//!
//! The packets of `ray::batch` serve again, made anew for every origin, of the segments that are asked for. These come in
//! the order of a tree, so that neighbours in order mostly are neighbours in direction.

use super::{
    Intersector,
    batch::{Active, trace_segments},
    directions::{GROUP, GROUPS, PACKET, Packet},
};
use glam::Vec3;

/// Points of one aligned block share packets with each other alone, lest a packet straddle distant clusters.
const BLOCK: u32 = 256;

/// Segments from one origin, and buffers that are kept from origin to origin.
#[derive(Default)]
pub struct SegmentBatch {
    members: Vec<u32>,
    segments: Vec<Vec3>,
    directions: Vec<Vec3>,
    stack: Vec<(u32, u8)>,
}

impl SegmentBatch {
    /// Calls `hidden(i)` for each of `wanted` (ascending indices into `ends`) that something lies before. Both ends of a
    /// segment lie off any surface.
    ///
    /// The result is that of [`Intersector::occluded_between`], to the bit.
    pub fn trace(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        ends: &[Vec3],
        wanted: &[u32],
        mut hidden: impl FnMut(u32),
    ) {
        let mut rest = wanted;
        while let Some(&first) = rest.first() {
            let block_end = first - first % BLOCK + BLOCK;
            let count = rest.iter().take(PACKET).take_while(|&&i| i < block_end).count();
            let (chunk, after) = rest.split_at(count);
            self.trace_packet(scene, origin, ends, chunk, &mut hidden);
            rest = after;
        }
    }

    fn trace_packet(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        ends: &[Vec3],
        chunk: &[u32],
        hidden: &mut impl FnMut(u32),
    ) {
        self.members.clear();
        self.members.extend(0..chunk.len() as u32);
        self.segments.clear();
        self.segments.extend(chunk.iter().map(|&i| ends[i as usize] - origin));
        self.directions.clear();
        self.directions.extend(self.segments.iter().map(|s| s.normalize_or(Vec3::Y)));
        let packet = Packet::of_segments(&self.members, &self.segments, &self.directions);
        let active: Active = std::array::from_fn(|g| {
            let used = packet.count.saturating_sub(g * GROUP).min(GROUP);
            ((1_u32 << used) - 1) as u8
        });
        let open = trace_segments(scene, &packet, origin, active, &mut self.stack);
        for (i, &index) in chunk.iter().enumerate() {
            if open[i / GROUP] >> (i % GROUP) & 1 == 0 {
                hidden(index);
            }
        }
    }
}

const _: () = assert!(GROUPS * GROUP == PACKET);
