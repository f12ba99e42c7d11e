//! Occlusion of a whole set of directions, or of points, from one origin by the boundaries of what is seen.
//!
//! Visibility changes along boundaries: nine rays of ten tell nothing new. One probe is traced in each block, and stands for
//! it. Where blocks that touch differ, a boundary runs between them, and is followed: eight rays of the seen side are
//! traced, and each eight whose neighbors differ from what is known or predicted of it, until nothing is left to trace.
//! What no probe meets and no boundary leads to is missed. An audit against all rays says how much that is.
//!
//! The result of an origin depends on nothing but it: not on other origins, and not on the order in which eights are traced.

mod directions;
mod follow;
mod graph;
mod segments;

pub use directions::{BoundarySet, BoundaryTracer};
pub use segments::{SegmentSet, SegmentTracer};

use super::directions::GROUP;

/// Whether a probe can stand for so many directions or points: a multiple of eight, or 1 where all are traced.
pub fn is_number_per_probe(number: usize) -> bool {
    number == 1 || (number > 0 && number.is_multiple_of(GROUP))
}

#[cfg(test)]
mod tests;
