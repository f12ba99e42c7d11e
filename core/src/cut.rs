//! Cuts: piecewise-constant functions over the leaves of a light tree (paper, 3.1 and 3.2).
//!
//! A cut is a left-to-right partition of the leaves into tree nodes with one value each. Its first leaf is a running
//! sum, so a node is only *(depth, value)*, in [`packed`] form 16 bits.

pub mod illumination;
pub mod lit;
pub mod merge;
pub mod packed;
mod renewal;
mod solid_angles;
mod visibility;

pub use renewal::{CutPart, cut_parts, is_uniform_solid_angle, is_uniform_visibility, leaves_below};
pub use solid_angles::{
    LARGEST_SOLID_ANGLE, SourceCriterion, SourceCutSelector, prune_sources, solid_angle, solid_angle_code,
    solid_angle_error, solid_angles,
};
pub use visibility::{CutCriterion, CutSelector, prune, squared_error};

use thiserror::Error;

/// Why a sequence of nodes is not a cut.
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

/// Checks that nodes of these depths partition the leaves of a tree of `height`. Stops at the node that ends at the
/// last leaf and returns the number of nodes.
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
