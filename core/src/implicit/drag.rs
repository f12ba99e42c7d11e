//! What leaves see while some objects move: what they see of the others is kept.

use super::{direct::Bins, layout::BinLayout, views::Views};
use crate::implicit::disc_forest::DiscForest;
use std::collections::BTreeSet;

/// What is seen of all that does not move, and which objects do.
#[derive(Clone, Debug)]
pub struct Drag {
    objects: BTreeSet<u32>,
    still: Bins,
    still_views: Views,
}

impl Drag {
    /// Before some objects are moved.
    pub fn begin(forest: &DiscForest, layout: BinLayout, objects: BTreeSet<u32>) -> Self {
        let still = Bins::walk(forest, layout, &|other| !objects.contains(&other));
        Self { objects, still_views: still.clone().views(), still }
    }

    /// The objects that move.
    pub fn objects(&self) -> &BTreeSet<u32> {
        &self.objects
    }

    /// What all leaves see where the objects are now: the same, bit for bit, as by a whole walk. Leaves of other objects look for
    /// the moved ones alone, their own look for everything.
    pub fn frame(&self, forest: &DiscForest) -> Views {
        let layout = self.still.layout();
        let moved = Bins::walk(forest, layout, &|object| self.objects.contains(&object));
        let mut views = self.still_views.with_nearer(&self.still, &moved);
        for leaves in self.objects.iter().map(|&object| forest.leaves_of(object)) {
            views.replace(leaves.start, &Bins::of_leaves(forest, layout, leaves, &|_| true).views());
        }
        views
    }
}
