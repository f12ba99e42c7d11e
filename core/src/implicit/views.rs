//! Views of leaves: a node or the sky in each cell.

use super::{
    direct::{Bins, EMPTY, node_of},
    layout::{AROUND_A_HOLE, BinLayout},
};
use rayon::prelude::*;

/// The node that each cell of each leaf sees: [`super::Bins`] after merging all layers.
///
/// Discs do not cover every ray of a surface. An empty cell with seven of eight neighbors filled takes the nearest of
/// them. Along the horizon, where cells have fewer neighbors, all of them must be filled.
#[derive(Clone, Debug, PartialEq)]
pub struct Views {
    layout: BinLayout,
    /// Number of the first leaf.
    first_leaf: u32,
    /// By leaf and cell; [`EMPTY`] for the sky.
    nodes: Vec<u32>,
}

impl Bins {
    /// The node that each bin sees, with holes closed.
    pub fn views(self) -> Views {
        Views::new(self.layout(), self.into_keys())
    }
}

impl Views {
    pub(super) fn new(layout: BinLayout, mut keys: Vec<u32>) -> Self {
        keys.par_chunks_exact_mut(layout.cells.len()).with_min_len(64).for_each_init(Vec::new, |found, nodes| {
            found.clear();
            found.extend_from_slice(nodes);
            close(found, layout.cells.side, nodes);
        });
        Self::of_nodes(layout, 0, keys)
    }

    /// Views from nodes by leaf and cell, with holes already closed. If they do not begin with the first leaf, they
    /// allow lookups but no gathering.
    pub fn of_nodes(layout: BinLayout, first_leaf: u32, nodes: Vec<u32>) -> Self {
        Self { layout, first_leaf, nodes }
    }

    /// These views of the bins of `still`, with nearer nodes of `moved` in front. Leaves that see nothing new keep their views.
    pub(super) fn with_nearer(&self, still: &Bins, moved: &Bins) -> Self {
        let mut views = self.clone();
        let rows = views.nodes.par_chunks_exact_mut(self.layout.cells.len()).enumerate().with_min_len(64);
        rows.for_each_init(Vec::new, |nearer, (leaf, nodes)| {
            let (still, moved) = (still.of_leaf(leaf as u32), moved.of_leaf(leaf as u32));
            if still.iter().zip(moved).any(|(still, moved)| moved < still) {
                nearer.clear();
                nearer.extend(still.iter().zip(moved).map(|(still, moved)| *still.min(moved)));
                close(nearer, self.layout.cells.side, nodes);
            }
        });
        views
    }

    /// Replaces the views of the leaves from `first` on.
    pub(super) fn replace(&mut self, first: u32, others: &Self) {
        let first = first as usize * self.layout.cells.len();
        self.nodes[first..first + others.nodes.len()].copy_from_slice(&others.nodes);
    }

    /// The nodes that a leaf sees, cell by cell; [`EMPTY`] where it sees the sky.
    pub fn of_leaf(&self, leaf: u32) -> &[u32] {
        let cells = self.layout.cells.len();
        let first = (leaf - self.first_leaf) as usize * cells;
        &self.nodes[first..first + cells]
    }

    /// The bin layout of each leaf.
    pub fn layout(&self) -> BinLayout {
        self.layout
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.nodes.len() / self.layout.cells.len()
    }

    /// The share of the hemisphere, by cosine, in which a leaf sees the sky.
    pub fn share_of_sky(&self, leaf: u32) -> f32 {
        let empty = self.of_leaf(leaf).iter().filter(|&&node| node == EMPTY).count();
        empty as f32 / self.layout.cells.len() as f32
    }
}

/// The nodes of keys, with holes closed.
fn close(keys: &[u32], side: usize, nodes: &mut [u32]) {
    for (cell, (node, &key)) in nodes.iter_mut().zip(keys).enumerate() {
        *node = match key {
            EMPTY => nearest_around(keys, side, cell).map_or(EMPTY, node_of),
            key => node_of(key),
        };
    }
}

/// The nearest neighbor of a hole; `None` for an opening.
fn nearest_around(keys: &[u32], side: usize, cell: usize) -> Option<u32> {
    let side = side as isize;
    let (row, column) = (cell as isize / side, cell as isize % side);
    let (mut nearest, mut open, mut all) = (EMPTY, 0, 0);
    for (dy, dx) in [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)] {
        let (y, x) = (row + dy, column + dx);
        if (0..side).contains(&y) && (0..side).contains(&x) {
            let key = keys[(y * side + x) as usize];
            nearest = nearest.min(key);
            open += usize::from(key == EMPTY);
            all += 1;
        }
    }
    (open <= all / AROUND_A_HOLE).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views(open: &[usize]) -> Views {
        let mut keys: Vec<u32> =
            (0..BinLayout::FINEST.cells.len() as u32).map(|cell| (1 + cell % 7) << 20 | cell).collect();
        open.iter().for_each(|&cell| keys[cell] = EMPTY);
        Views::new(BinLayout::FINEST, keys)
    }

    #[test]
    fn a_hole_takes_the_nearest_neighbour() {
        let views = views(&[210]);
        let around = [189, 190, 191, 209, 211, 229, 230, 231];
        let nearest = around.into_iter().min_by_key(|cell| cell % 7).unwrap();
        assert_eq!(views.of_leaf(0)[210], nearest);
        assert_eq!((views.of_leaf(0)[17], views.share_of_sky(0)), (17, 0.0));
    }

    #[test]
    fn openings_stay_open() {
        let square = [189, 190, 209, 210];
        assert_eq!(views(&square).share_of_sky(0), 0.01, "two cells by two");
        let horizon: Vec<usize> = (0..20).collect();
        assert_eq!(views(&horizon).share_of_sky(0), 0.05, "a row along the horizon");
        assert_eq!(views(&(0..400).collect::<Vec<_>>()).share_of_sky(0), 1.0);
        assert_eq!(views(&[0, 19, 57]).share_of_sky(0), 0.0, "negative control: these are holes");
    }
}
