//! Visibility of many points from one: batches of segments with a common origin.
//!
//! The packets of `ray::batch` are rebuilt for every origin from the requested segments. Segments are sorted by direction first,
//! so near and far ends in one direction share a packet: all of them hit the same triangles, and the far ones mostly end at a near
//! one. In the order of a tree over the ends, each packet in one direction would walk the hierarchy separately.

use super::{
    Intersector,
    batch::{Active, Walk},
    directions::{GROUP, GROUPS, PACKET, Packet},
};
use crate::simd::InstructionSet;
use glam::Vec3;

/// Cells along each side of the square unfolded from the sphere of directions; a power of two.
const CELLS: u32 = 64;

/// Segments from one origin, and reused buffers.
#[derive(Default)]
pub struct SegmentBatch {
    segments: Vec<Vec3>,
    directions: Vec<Vec3>,
    cells: Vec<u16>,
    /// Start of each cell's segments in `order`.
    starts: Vec<u32>,
    order: Vec<u32>,
    stack: Vec<(u32, u8)>,
}

impl SegmentBatch {
    /// Calls `hidden(i)`, in any order, for each of `wanted` (indices into `ends`) that is hidden from the origin. Both
    /// ends of a segment lie off any surface. Returns the number of segments traced.
    ///
    /// The result equals [`Intersector::occluded_between`], to the bit.
    pub fn trace(
        &mut self,
        scene: &Intersector,
        origin: Vec3,
        ends: &[Vec3],
        wanted: &[u32],
        mut hidden: impl FnMut(u32),
    ) -> u64 {
        self.segments.clear();
        self.segments.extend(wanted.iter().map(|&i| ends[i as usize] - origin));
        self.directions.clear();
        self.directions.extend(self.segments.iter().map(|s| s.normalize_or(Vec3::Y)));
        self.sort_by_direction();
        let set = InstructionSet::widest();
        for members in self.order.chunks(PACKET) {
            let packet = Packet::of_segments(members, &self.segments, &self.directions);
            let active: Active = std::array::from_fn(|g| {
                let used = packet.count.saturating_sub(g * GROUP).min(GROUP);
                ((1_u32 << used) - 1) as u8
            });
            let open = set.run(Walk::<true> { scene, packet: &packet, origin, active, stack: &mut self.stack });
            for (i, &member) in members.iter().enumerate() {
                if open[i / GROUP] >> (i % GROUP) & 1 == 0 {
                    hidden(wanted[member as usize]);
                }
            }
        }
        wanted.len() as u64
    }

    /// Fills `order` with all segments, sorted so that neighbors in direction are adjacent.
    fn sort_by_direction(&mut self) {
        self.cells.clear();
        self.cells.extend(self.directions.iter().map(|&d| cell(d)));
        self.starts.clear();
        self.starts.resize((CELLS * CELLS + 1) as usize, 0);
        self.cells.iter().for_each(|&cell| self.starts[usize::from(cell) + 1] += 1);
        (1..self.starts.len()).for_each(|i| self.starts[i] += self.starts[i - 1]);
        self.order.clear();
        self.order.resize(self.cells.len(), 0);
        for (i, &cell) in self.cells.iter().enumerate() {
            let place = &mut self.starts[usize::from(cell)];
            self.order[*place as usize] = i as u32;
            *place += 1;
        }
    }
}

/// The cell of a direction, along a Z-curve through the octahedron unfolded to a square.
#[inline(always)]
fn cell(d: Vec3) -> u16 {
    let sum = d.abs().element_sum();
    let (x, y) = (d.x / sum, d.y / sum);
    let (x, y) = if d.z < 0.0 { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) } else { (x, y) };
    let step = |v: f32| (((0.5 * v + 0.5) * CELLS as f32) as u32).min(CELLS - 1);
    (spread(step(x)) | spread(step(y)) << 1) as u16
}

/// The bits of a number below 256, each followed by a zero.
#[inline(always)]
fn spread(v: u32) -> u32 {
    let v = (v | v << 4) & 0x0f0f;
    let v = (v | v << 2) & 0x3333;
    (v | v << 1) & 0x5555
}

const _: () = assert!(GROUPS * GROUP == PACKET && CELLS.is_power_of_two() && CELLS <= 256);
