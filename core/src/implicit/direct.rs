//! The walk: each surfel finds the nodes it sees, independently.
//!
//! The paper links nodes with nodes, refines and pushes down (4.2), but in the end only leaves receive. Here each leaf
//! walks the forest itself and keeps the nearest node for each of its cells of the hemisphere. Nothing is scattered, no
//! order matters, and nothing needs refinement. Three more departures, each because the paper's choice loses light:
//!
//! * Bins are cells of equal cosine weight in the leaf's own frame ([`crate::sphere::concentric`]) and not texels of a
//!   cube map in the world, half of which lie behind the leaf. All bins have equal weight, so Eq. 5's form factor of
//!   the node is not needed: with it a wall in a room of 4,096 surfels sends 0.55 of its light.
//! * A node enters every cell that its disc covers, not only the cell of its center, and is split as long as it covers
//!   more than 1.4. Otherwise a closed room sees the sky in 17 % of its bins.
//! * An empty bin with at least seven filled neighbors is a hole in the covering and not an opening; see [`Views`](super::Views).

mod cover;
mod key;
mod visit;

pub use key::{DistanceCodes, EMPTY, node_of};

use super::layout::{AROUND_A_HOLE, BinLayout};
use crate::{
    implicit::{
        disc_forest::DiscForest,
        forest::{
            nodes::{Block, FLAT},
            quadtrees::CHILDREN,
        },
    },
    simd::{InstructionSet, Kernel, Lanes},
};
use cover::{CellDirections, Filled, NOTHING};
use rayon::prelude::*;
use std::ops::Range;
use visit::{Receiver, Visits};

/// Constants that the walk shares with its kernel.
pub const CONSTANTS: [(&str, f32); 7] = [
    ("OVERLAP", cover::OVERLAP),
    ("STEEPEST_MAP", cover::STEEPEST),
    ("WIDE", cover::WIDE),
    ("CHORD", cover::CHORD),
    ("GRAZING", visit::GRAZING),
    ("PARALLEL", visit::PARALLEL),
    ("FLAT", FLAT),
];
/// Integer constants that the walk shares with its kernel.
pub const WHOLE_CONSTANTS: [(&str, u32); 7] = [
    ("MOST_CELLS", BinLayout::FINEST.cells.len() as u32),
    ("EMPTY", EMPTY),
    ("CHILDREN", CHILDREN as u32),
    ("NODE_BITS", key::NODE_BITS),
    ("LARGEST_CODE", key::LARGEST_CODE),
    ("DROPPED_BITS", key::DROPPED),
    ("AROUND_A_HOLE", AROUND_A_HOLE as u32),
];

/// The nearest nodes of some leaves, cell by cell, as keys of distance and node; [`EMPTY`] where there is none. Four
/// bytes per cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins {
    leaves: Range<u32>,
    layout: BinLayout,
    keys: Vec<u32>,
}

impl Bins {
    /// The nodes of the selected `objects` that all leaves of a forest see.
    pub fn walk(forest: &DiscForest, layout: BinLayout, objects: &dyn Fn(u32) -> bool) -> Self {
        Self::of_leaves(forest, layout, 0..forest.discs().len() as u32, objects)
    }

    /// [`Self::walk`] for some leaves alone.
    pub fn of_leaves(
        forest: &DiscForest,
        layout: BinLayout,
        leaves: Range<u32>,
        objects: &dyn Fn(u32) -> bool,
    ) -> Self {
        Self::with_instructions(forest, layout, leaves, objects, InstructionSet::widest())
    }

    fn with_instructions(
        forest: &DiscForest,
        layout: BinLayout,
        leaves: Range<u32>,
        objects: &dyn Fn(u32) -> bool,
        instructions: InstructionSet,
    ) -> Self {
        let (scene, cells) = (Scene::new(forest, layout, objects), layout.cells.len());
        let discs = &forest.discs()[leaves.start as usize..leaves.end as usize];
        let mut keys = vec![EMPTY; discs.len() * cells];
        let rows = keys.par_chunks_exact_mut(cells).zip(discs).with_min_len(16);
        rows.for_each_init(Visits::default, |visits, (row, disc)| {
            let receiver = Receiver { position: disc.position, frame: layout.frame_of(disc) };
            let filled = instructions.run(Look { scene: &scene, receiver, visits });
            row.copy_from_slice(&filled[..cells]);
        });
        Self { leaves, layout, keys }
    }

    /// The leaves of these bins.
    pub fn leaves(&self) -> Range<u32> {
        self.leaves.clone()
    }

    /// The bin layout of each leaf.
    pub fn layout(&self) -> BinLayout {
        self.layout
    }

    /// The keys of a leaf, cell by cell.
    pub fn of_leaf(&self, leaf: u32) -> &[u32] {
        let cells = self.layout.cells.len();
        let first = (leaf - self.leaves.start) as usize * cells;
        &self.keys[first..first + cells]
    }

    /// The nearer of two keys in each bin: the view of both sets of objects together. Both have the same leaves and bins.
    pub fn nearer(&self, other: &Self) -> Self {
        assert_eq!((&self.leaves, self.layout), (&other.leaves, other.layout), "the same bins");
        let both = self.keys.par_iter().zip(&other.keys).with_min_len(1 << 16);
        Self { keys: both.map(|(a, b)| *a.min(b)).collect(), leaves: self.leaves(), layout: self.layout }
    }

    /// The keys of all leaves, cell by cell.
    pub(super) fn into_keys(self) -> Vec<u32> {
        self.keys
    }
}

/// The scene of a walk.
struct Scene<'a> {
    forest: &'a DiscForest,
    /// Blocks of the roots of the objects to walk.
    roots: Vec<Block>,
    directions: CellDirections,
    codes: DistanceCodes,
    /// The largest integral of the cosine over a node, in steradians.
    limit: f32,
}

impl<'a> Scene<'a> {
    fn new(forest: &'a DiscForest, layout: BinLayout, objects: &dyn Fn(u32) -> bool) -> Self {
        let mut roots = forest.blocks()[..forest.shape().root_blocks()].to_vec();
        for object in (0..forest.shape().trees().len()).filter(|&object| !objects(object as u32)) {
            roots[object / CHILDREN].area[object % CHILDREN] = 0.0;
        }
        Self {
            forest,
            roots,
            directions: CellDirections::new(layout.cells),
            codes: DistanceCodes::of(forest),
            limit: layout.node_limit(),
        }
    }
}

/// The walk of a leaf.
struct Look<'a> {
    scene: &'a Scene<'a>,
    receiver: Receiver,
    visits: &'a mut Visits,
}

impl Kernel for Look<'_> {
    type Output = Filled;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Filled {
        let Self { scene, receiver, visits } = self;
        let blocks = scene.forest.blocks();
        visits.find::<L>(&scene.roots, blocks, &receiver, scene.limit);
        let mut bins = NOTHING;
        cover::fill::<L>(&mut bins, &visits.ends, blocks, &receiver, (&scene.directions, scene.codes));
        bins
    }
}

#[cfg(test)]
mod tests;
