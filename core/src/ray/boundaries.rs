//! Occlusion of a whole set of directions or points from one origin, by following visibility boundaries.
//!
//! Visibility changes along boundaries: nine rays of ten give no new information. One probe is traced in each block,
//! and stands for it. Where adjacent blocks differ, a boundary runs between them, and is followed: eight rays of the
//! visible side are traced, then each eight whose neighbors differ from its known or predicted visibility, until none
//! is left. Details between probes that no boundary leads to are missed. An audit against all rays measures them.
//!
//! The result of an origin is independent of other origins, and of the order in which eights are traced.

mod directions;
mod follow;
mod graph;
mod segments;

pub use directions::{BoundarySet, BoundaryTables, BoundaryTracer};
pub use segments::{SegmentSet, SegmentTracer};

use super::directions::GROUP;

/// Whether a probe can stand for `number` directions or points: a multiple of eight, or 1 to trace all.
pub fn is_number_per_probe(number: usize) -> bool {
    number == 1 || (number > 0 && number.is_multiple_of(GROUP))
}

#[cfg(test)]
mod tests;
