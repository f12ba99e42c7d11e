//! Cuts with values in full precision, and their merges.

use crate::cut::{
    CutError,
    merge::{Cursor, Interval, merge},
    validate_depths,
};

/// One node of a cut: its depth below the root and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutNode {
    /// 0 for the root, `H` for a leaf.
    pub depth: u8,
    /// Value of the function on all leaves below the node.
    pub value: f32,
}

/// A cut in full precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    height: u32,
    nodes: Vec<CutNode>,
}

impl Cut {
    /// Creates a cut from nodes, left to right.
    ///
    /// # Errors
    /// Nodes that do not partition the `2^height` leaves.
    pub fn new(height: u32, nodes: Vec<CutNode>) -> Result<Self, CutError> {
        let count = validate_depths(height, nodes.iter().map(|n| u32::from(n.depth)))?;
        if count != nodes.len() {
            return Err(CutError::Misplaced { node: count, depth: u32::from(nodes[count].depth), first: 1 << height });
        }
        Ok(Self { height, nodes })
    }

    /// The cut of all leaves. `values.len()` is a power of two.
    pub fn full(values: &[f32]) -> Self {
        let height = values.len().ilog2();
        let nodes = values.iter().map(|&value| CutNode { depth: height as u8, value }).collect();
        Self { height, nodes }
    }

    /// Height of the tree.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The nodes, left to right.
    pub fn nodes(&self) -> &[CutNode] {
        &self.nodes
    }

    /// The function on every leaf.
    pub fn expand(&self) -> Vec<f32> {
        let repeat = |n: &CutNode| std::iter::repeat_n(n.value, 1 << (self.height - u32::from(n.depth)));
        self.nodes.iter().flat_map(repeat).collect()
    }

    /// A cursor at the first node.
    pub fn cursor(&self) -> CutCursor<'_> {
        CutCursor::new(self)
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
    fn new(cut: &'a Cut) -> Self {
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

/// `Σ |C| Π values` over the merged cut: the multi-product integral (paper, Eq. 4), with unit weight per leaf.
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

/// Visits the merged cut with the values of all cuts at each node; `values` is the buffer for them.
pub fn visit_values(cuts: &[&Cut], values: &mut [f32], mut visit: impl FnMut(Interval, &[f32])) {
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
