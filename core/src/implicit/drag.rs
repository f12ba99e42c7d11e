//! Views while some objects move: the view of the static objects is kept.

use super::{direct::Bins, layout::BinLayout, views::Views};
use crate::implicit::disc_forest::DiscForest;
use std::collections::BTreeSet;

/// The view of all static objects, and the set of moving ones.
#[derive(Clone, Debug)]
pub struct Drag {
    objects: BTreeSet<u32>,
    still: Bins,
    still_views: Views,
}

impl Drag {
    /// Starts moving some objects.
    pub fn begin(forest: &DiscForest, layout: BinLayout, objects: BTreeSet<u32>) -> Self {
        let still = Bins::walk(forest, layout, &|other| !objects.contains(&other));
        Self { objects, still_views: still.clone().views(), still }
    }

    /// The objects that move.
    pub fn objects(&self) -> &BTreeSet<u32> {
        &self.objects
    }

    /// The views at the current poses, identical bit for bit to a whole walk. Leaves of static objects walk only the
    /// moving ones; leaves of moving objects walk everything.
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
