//! Merging any number of cuts in one traversal (paper, 3.2), in interval form.
//!
//! All cuts partition the same leaves and their nodes are nested, so no overlap test is needed. At leaf `p`, the finest
//! node is exactly `[p, e)`, where `e` is the smallest end of the cuts' current nodes. The number of visits is the size
//! of the merged cut. The paper's loop over postorder indices visits the same nodes in the same order; it is the oracle
//! of the tests.

/// A node of a merged cut as an interval of leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// First leaf.
    pub first: u32,
    /// One past the last leaf.
    pub end: u32,
}

impl Interval {
    /// Number of leaves.
    #[inline(always)]
    pub fn size(self) -> u32 {
        self.end - self.first
    }

    /// Heap index of the node in a tree of `leaves` leaves.
    #[inline(always)]
    pub fn heap_index(self, leaves: u32) -> u32 {
        // The size is a power of two.
        (leaves + self.first) >> self.size().trailing_zeros()
    }
}

/// A position in a cut that moves left to right.
pub trait Cursor {
    /// One past the last leaf of the current node.
    fn end(&self) -> u32;
    /// Steps to the next node. Called at most once per node, and not after the last leaf.
    fn advance(&mut self);
    /// Steps if the current node ends at `end`. The outcome is hard to predict, so a branch-free version is fastest.
    #[inline(always)]
    fn advance_from(&mut self, end: u32) {
        if self.end() == end {
            self.advance();
        }
    }
}

/// Visits every node of the merged cut of `cursors`, left to right. At each visit all cursors are at the nodes that
/// contain it.
///
/// The visitor computes a product, a sum, an interpolation, or any mixture of them.
#[inline(always)]
pub fn merge<C: Cursor>(leaves: u32, cursors: &mut [C], visit: impl FnMut(Interval, &[C])) {
    merge_within(Interval { first: 0, end: leaves }, cursors, visit);
}

/// [`merge`] restricted to the leaves of one node. The cursors start at the nodes that contain its first leaf, and end
/// at the nodes that contain its last.
#[inline(always)]
pub fn merge_within<C: Cursor>(within: Interval, cursors: &mut [C], mut visit: impl FnMut(Interval, &[C])) {
    let mut first = within.first;
    while first < within.end {
        let end = cursors.iter().fold(within.end, |e, c| e.min(c.end()));
        visit(Interval { first, end }, cursors);
        first = end;
        if first < within.end {
            for cursor in cursors.iter_mut() {
                cursor.advance_from(end);
            }
        }
    }
}

#[cfg(test)]
mod tests;
