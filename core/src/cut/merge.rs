//! Merging any number of cuts in one traversal (paper, 3.2), in interval form.
//!
//! All cuts partition the same leaves and their nodes are nested, so no overlap test is needed: with the current leaf
//! `p` and, per cut, the end of its current node, the finest node is exactly `[p, e)` where `e` is the smallest end.
//! The number of visits is the size of the merged cut. The paper's loop over postorder indices visits the same nodes in
//! the same order; it stands in the tests as the oracle.

use super::{Cut, CutNode};

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
        (leaves + self.first) / self.size()
    }
}

/// A position in a cut that moves left to right.
pub trait Cursor {
    /// One past the last leaf of the current node.
    fn end(&self) -> u32;
    /// Steps to the next node. Called at most once a node, and not after the last leaf.
    fn advance(&mut self);
}

/// Visits every node of the merged cut of `cursors`, left to right, with all cursors at the nodes that hold it.
///
/// The visitor forms what is wanted there: a product, a sum, an interpolation, or any mixture of them.
#[inline(always)]
pub fn merge<C: Cursor>(leaves: u32, cursors: &mut [C], mut visit: impl FnMut(Interval, &[C])) {
    let mut first = 0;
    while first < leaves {
        let end = cursors.iter().fold(leaves, |e, c| e.min(c.end()));
        visit(Interval { first, end }, cursors);
        first = end;
        if first < leaves {
            for cursor in cursors.iter_mut().filter(|c| c.end() == end) {
                cursor.advance();
            }
        }
    }
}

/// [`Cursor`] of a [`Cut`].
#[derive(Clone, Debug)]
pub struct CutCursor<'a> {
    cut: &'a Cut,
    position: usize,
    end: u32,
}

impl<'a> CutCursor<'a> {
    pub(super) fn new(cut: &'a Cut) -> Self {
        let mut cursor = Self { cut, position: usize::MAX, end: 0 };
        cursor.advance();
        cursor
    }

    /// Value of the current node.
    pub fn value(&self) -> f32 {
        self.cut.nodes[self.position].value
    }
}

impl Cursor for CutCursor<'_> {
    fn end(&self) -> u32 {
        self.end
    }

    fn advance(&mut self) {
        self.position = self.position.wrapping_add(1);
        self.end += 1 << (self.cut.height - u32::from(self.cut.nodes[self.position].depth));
    }
}

/// The cut of `f` applied to the values of several cuts of the same tree, node by node of the merged cut.
///
/// # Panics
/// If there are no cuts or their trees differ in height.
pub fn combine(cuts: &[&Cut], mut f: impl FnMut(&[f32]) -> f32) -> Cut {
    let height = cuts[0].height;
    let mut values = vec![0.0; cuts.len()];
    let mut nodes = Vec::new();
    visit_values(cuts, &mut values, |interval, values| {
        let depth = (height - interval.size().ilog2()) as u8;
        nodes.push(CutNode { depth, value: f(values) });
    });
    Cut { height, nodes }
}

/// `Σ |C| Π values` over the merged cut: the multi-product integral (paper, Eq. 4), with unit weight a leaf.
///
/// # Panics
/// If there are no cuts or their trees differ in height.
pub fn product_integral(cuts: &[&Cut]) -> f64 {
    let mut values = vec![0.0; cuts.len()];
    let mut sum = 0.0;
    visit_values(cuts, &mut values, |interval, values| {
        sum += f64::from(interval.size()) * values.iter().map(|&v| f64::from(v)).product::<f64>();
    });
    sum
}

fn visit_values(cuts: &[&Cut], values: &mut [f32], mut visit: impl FnMut(Interval, &[f32])) {
    let height = cuts[0].height;
    assert!(cuts.iter().all(|c| c.height == height), "cuts of trees of different height cannot be merged");
    let mut cursors: Vec<_> = cuts.iter().map(|c| c.cursor()).collect();
    merge(1 << height, &mut cursors, |interval, cursors| {
        for (value, cursor) in values.iter_mut().zip(cursors) {
            *value = cursor.value();
        }
        visit(interval, values);
    });
}

#[cfg(test)]
mod tests;
