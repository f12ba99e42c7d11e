//! The bins of a leaf.

use crate::{
    implicit::forest::nodes::Disc,
    sphere::{concentric::HemisphereCells, frame_around},
};
use glam::Mat3;

/// Cells that a node may cover before its children replace it. At 2 outlines are coarser, and a walk of 4,096 surfels
/// takes 31 ms instead of 36.
const CELLS_OF_NODE: f32 = 1.4;
/// One empty neighbor among this many still counts as a hole. With two in eight, real openings close as well.
pub(super) const AROUND_A_HOLE: usize = 8;

/// Division of each leaf's hemisphere into bins: cells of equal cosine weight in the leaf's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinLayout {
    /// The bins.
    pub cells: HemisphereCells,
    /// Rotation of the leaves' tangents in radians: averages over rotations hide the cells.
    pub turn: f32,
}

impl BinLayout {
    /// Largest number of cells along an edge of the square.
    pub const MOST_SIDE: usize = 20;
    /// The finest layout.
    pub const FINEST: Self = Self::new(Self::MOST_SIDE);

    /// A layout of `side` x `side` bins, 1 to [`Self::MOST_SIDE`] along an edge.
    pub const fn new(side: usize) -> Self {
        assert!(0 < side && side <= Self::MOST_SIDE, "one bin or more, and not more than fit");
        Self { cells: HemisphereCells { side }, turn: 0.0 }
    }

    /// The same bins, turned by an angle in radians.
    pub const fn turned(self, turn: f32) -> Self {
        Self { turn, ..self }
    }

    /// Tangents and normal of a leaf, the frame of its bins.
    pub fn frame_of(self, disc: &Disc) -> Mat3 {
        frame_around(disc.normal) * Mat3::from_rotation_z(self.turn)
    }

    /// The largest integral of the cosine over a node with children, in steradians.
    pub fn node_limit(self) -> f32 {
        CELLS_OF_NODE * self.cells.weight()
    }
}
