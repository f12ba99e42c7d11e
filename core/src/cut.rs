//! Cuts: piecewise-constant functions over the leaves of a light tree (paper, 3.1 and 3.2).
//!
//! A cut is a left-to-right partition of the leaves into tree nodes with one value each. Its first leaf is a running
//! sum, so a node is only *(depth, value)*. [`Cut`] holds values in full precision, [`packed`] 16 bits a node.

pub mod illumination;
pub mod merge;
pub mod packed;
mod prune_sources;
mod select;
mod select_sources;

pub use prune_sources::prune_sources;
pub use select::{CutCriterion, CutSelector, prune};
pub use select_sources::{SourceCriterion, SourceCutSelector};

use thiserror::Error;

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

/// Why a sequence of nodes is no cut.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum CutError {
    /// A node is deeper than the tree.
    #[error("node {node} has depth {depth} in a tree of height {height}")]
    Depth {
        /// Position in the cut.
        node: usize,
        /// Its depth.
        depth: u32,
        /// Height of the tree.
        height: u32,
    },
    /// A node does not start at a multiple of its size, or reaches past the end.
    #[error("node {node} of depth {depth} cannot start at leaf {first}")]
    Misplaced {
        /// Position in the cut.
        node: usize,
        /// Its depth.
        depth: u32,
        /// First leaf.
        first: u32,
    },
    /// The nodes do not reach the last leaf.
    #[error("the cut ends at leaf {0}, before the last")]
    Incomplete(u32),
}

/// Checks that nodes of these depths partition the leaves of a tree of `height`, and returns how many there are;
/// stops at the node that ends at the last leaf.
///
/// # Errors
/// The first node that breaks the partition.
pub fn validate_depths(height: u32, depths: impl IntoIterator<Item = u32>) -> Result<usize, CutError> {
    let mut first = 0_u32;
    for (node, depth) in depths.into_iter().enumerate() {
        if depth > height {
            return Err(CutError::Depth { node, depth, height });
        }
        let size = 1 << (height - depth);
        if !first.is_multiple_of(size) || first + size > 1 << height {
            return Err(CutError::Misplaced { node, depth, first });
        }
        first += size;
        if first == 1 << height {
            return Ok(node + 1);
        }
    }
    Err(CutError::Incomplete(first))
}

impl Cut {
    /// A cut from its nodes, left to right.
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

    /// The cut of all leaves: the function itself. `values.len()` is a power of two.
    pub fn full(values: &[f32]) -> Self {
        let height = values.len().ilog2();
        let nodes = values.iter().map(|&value| CutNode { depth: height as u8, value }).collect();
        Self { height, nodes }
    }

    /// Height of the tree that this is a cut of.
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
    pub fn cursor(&self) -> merge::CutCursor<'_> {
        merge::CutCursor::new(self)
    }
}
