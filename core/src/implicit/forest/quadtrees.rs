//! The shape of a forest: a balanced quadtree per object, for any number of leaves.
//!
//! Leaves of an object are halved twice per level; one half of an odd number is larger by one. So all leaves of an
//! object have equal depth except for one binary step. The root of an object has two children if its number of leaves
//! requires an odd number of halvings: then the lowest blocks hold two to four leaves, and three on average.
//!
//! The children of a node make up a block of four slots, some of which may be empty. Node `4 b + s` is slot `s` of
//! block `b`. The roots come first, four to a block; the blocks of each object follow, parents before children.

use std::ops::Range;

/// Largest number of children.
pub const CHILDREN: usize = 4;

/// Marks a slot without a node.
const NONE: u32 = u32::MAX;
/// Bit of a slot that holds a leaf; the others are its number.
const LEAF: u32 = 1 << 31;

/// Contents of a slot of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Nothing.
    Empty,
    /// A leaf, by its number.
    Leaf(u32),
    /// A node whose children are in this block.
    Inner(u32),
}

/// The quadtree of an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tree {
    /// Its leaves.
    pub leaves: Range<u32>,
    /// Its blocks, without the one that holds its root.
    pub blocks: Range<u32>,
}

/// The quadtrees of all objects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Quadtrees {
    slots: Vec<u32>,
    /// The leaves below each node.
    spans: Vec<Range<u32>>,
    /// The node above each block; a root has none.
    parents: Vec<u32>,
    leaf_nodes: Vec<u32>,
    trees: Vec<Tree>,
}

impl Quadtrees {
    /// Trees for objects with these numbers of leaves. An object without leaves has no nodes.
    pub fn new(leaves: &[u32]) -> Self {
        let mut forest = Self::default();
        (0..leaves.len().div_ceil(CHILDREN)).for_each(|_| _ = forest.push_block(NONE));
        let mut first = 0;
        for (object, &count) in leaves.iter().enumerate() {
            forest.grow(object as u32, first..first + count);
            first += count;
        }
        forest
    }

    fn push_block(&mut self, parent: u32) -> u32 {
        self.slots.extend([NONE; CHILDREN]);
        self.spans.extend([const { 0..0 }; CHILDREN]);
        self.parents.push(parent);
        self.parents.len() as u32 - 1
    }

    /// Adds the tree of an object, level by level.
    fn grow(&mut self, root: u32, leaves: Range<u32>) {
        let halvings = (leaves.len() as u32).max(1).next_power_of_two().ilog2();
        let first_block = self.parents.len() as u32;
        let mut level = if leaves.is_empty() { vec![] } else { vec![(root, leaves.clone())] };
        let mut quarters = halvings.is_multiple_of(2);
        while !level.is_empty() {
            level = level.into_iter().flat_map(|(node, span)| self.place(node, span, quarters)).collect();
            quarters = true;
        }
        self.trees.push(Tree { leaves, blocks: first_block..self.parents.len() as u32 });
    }

    /// Sets the span of a node and returns its children, for which it adds a block.
    fn place(&mut self, node: u32, span: Range<u32>, quarters: bool) -> Vec<(u32, Range<u32>)> {
        self.spans[node as usize] = span.clone();
        if span.len() == 1 {
            self.slots[node as usize] = LEAF | span.start;
            self.leaf_nodes.push(node);
            return vec![];
        }
        let block = self.push_block(node);
        self.slots[node as usize] = block;
        let spans = if quarters { halves(span).flat_map(halves).collect() } else { halves(span).collect::<Vec<_>>() };
        (block * CHILDREN as u32..).zip(spans).collect()
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.leaf_nodes.len()
    }

    /// Number of nodes including empty slots.
    pub fn nodes(&self) -> usize {
        self.slots.len()
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.parents.len()
    }

    /// Number of blocks with roots, which come first.
    pub fn root_blocks(&self) -> usize {
        self.trees.len().div_ceil(CHILDREN)
    }

    /// The trees, object by object.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// The slot at a node number.
    #[inline]
    pub fn slot(&self, node: u32) -> Slot {
        match self.slots[node as usize] {
            NONE => Slot::Empty,
            leaf if leaf & LEAF != 0 => Slot::Leaf(leaf & !LEAF),
            block => Slot::Inner(block),
        }
    }

    /// The leaves below a node; a leaf is its own span.
    pub fn span(&self, node: u32) -> Range<u32> {
        self.spans[node as usize].clone()
    }

    /// The node above a block; none for blocks of roots.
    pub fn parent(&self, block: u32) -> Option<u32> {
        Some(self.parents[block as usize]).filter(|&parent| parent != NONE)
    }

    /// The nodes of a block.
    pub fn nodes_of(&self, block: u32) -> impl Iterator<Item = u32> {
        (block * CHILDREN as u32..(block + 1) * CHILDREN as u32).filter(|&node| self.slot(node) != Slot::Empty)
    }

    /// The node of each leaf.
    pub fn leaf_nodes(&self) -> &[u32] {
        &self.leaf_nodes
    }
}

/// The two halves of a span, or its single leaf.
fn halves(span: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    let middle = span.start + span.len() as u32 / 2;
    [span.start..middle, middle..span.end].into_iter().filter(|half| !half.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves below a node with their depths, by descent.
    fn descend(forest: &Quadtrees, node: u32, depth: u32, out: &mut Vec<(u32, u32)>) {
        match forest.slot(node) {
            Slot::Empty => panic!("an empty slot below a node"),
            Slot::Leaf(leaf) => out.push((leaf, depth)),
            Slot::Inner(block) => {
                assert_eq!(forest.parent(block), Some(node));
                forest.nodes_of(block).for_each(|child| descend(forest, child, depth + 1, out));
            }
        }
    }

    #[test]
    fn every_leaf_is_below_the_root_of_its_object_at_nearly_one_depth() {
        let counts: Vec<u32> = (0..70).chain([256, 257, 1000, 4096]).collect();
        let forest = Quadtrees::new(&counts);
        assert_eq!(forest.leaves() as u32, counts.iter().sum::<u32>());
        for (object, (tree, &count)) in forest.trees().iter().zip(&counts).enumerate() {
            let mut found = Vec::new();
            if count > 0 {
                descend(&forest, object as u32, 0, &mut found);
            }
            let leaves: Vec<u32> = found.iter().map(|f| f.0).collect();
            assert_eq!(leaves, tree.leaves.clone().collect::<Vec<_>>(), "in order, each once");
            let depths = found.iter().map(|f| f.1);
            let (least, most) = (depths.clone().min().unwrap_or(0), depths.max().unwrap_or(0));
            assert!(most - least <= 1 && most <= count.max(1).next_power_of_two().ilog2().div_ceil(2));
        }
    }

    #[test]
    fn the_lowest_blocks_are_at_least_half_full() {
        for count in 2..300 {
            let forest = Quadtrees::new(&[count]);
            let fewest = (1..forest.blocks() as u32).map(|block| forest.nodes_of(block).count()).min();
            assert!(fewest >= Some(2), "{count} leaves");
        }
        let full = Quadtrees::new(&[4096]);
        assert_eq!(full.blocks(), 1 + 4095 / 3);
    }

    #[test]
    fn spans_and_leaf_nodes_agree() {
        let forest = Quadtrees::new(&[37, 0, 5]);
        for (leaf, &node) in forest.leaf_nodes().iter().enumerate() {
            let leaf = match forest.slot(node) {
                Slot::Leaf(number) => number,
                _ => panic!("leaf {leaf}"),
            };
            assert_eq!(forest.span(node), leaf..leaf + 1);
        }
        assert_eq!((forest.span(0), forest.span(2)), (0..37, 37..42));
        assert_eq!(forest.slot(1), Slot::Empty);
    }
}
