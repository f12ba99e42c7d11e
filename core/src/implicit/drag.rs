//! Bins while one object moves: what is seen of the others is kept.

use super::direct::Bins;
use crate::surfel::disc_forest::DiscForest;

/// Bins of all that does not move, and which object does.
#[derive(Clone, Debug)]
pub struct Drag {
    object: u32,
    still: Bins,
}

impl Drag {
    /// Before an object is moved.
    pub fn begin(forest: &DiscForest, turn: f32, object: u32) -> Self {
        Self { object, still: Bins::walk(forest, turn, &|other| other != object) }
    }

    /// The object that moves.
    pub fn object(&self) -> u32 {
        self.object
    }

    /// The bins of all leaves where the object is now: the same, bit for bit, as those of a whole walk. Leaves of other objects
    /// look for the moved one alone, its own look for everything.
    pub fn frame(&self, forest: &DiscForest) -> Bins {
        let turn = self.still.turn();
        let mut bins = self.still.nearer(&Bins::walk(forest, turn, &|object| object == self.object));
        bins.replace(&Bins::of_leaves(forest, turn, forest.leaves_of(self.object), &|_| true));
        bins
    }
}
