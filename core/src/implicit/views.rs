//! What leaves see: a node in each cell, or the sky.

use super::direct::{Bins, CELLS, EMPTY, frame_of, node_of};
use crate::surfel::disc_forest::DiscForest;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::LazyLock;

/// One empty neighbour in so many still makes a hole. With two in eight and more, real openings close as well.
pub(super) const AROUND_A_HOLE: usize = 8;

/// Unit directions of the cells in the frame of a leaf.
static CELL_DIRECTIONS: LazyLock<Vec<Vec3>> =
    LazyLock::new(|| (0..CELLS.len()).map(|cell| CELLS.direction_of(cell)).collect());

/// The node that each cell of each leaf sees. It is what [`super::Bins`] become once all layers are in them.
///
/// Discs do not cover every ray of a surface. An empty cell of which seven of the eight neighbours are filled takes the
/// nearest of these. Along the horizon, where cells have fewer neighbours, all of them must be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Views {
    turn: u32,
    /// The leaf that comes first.
    first_leaf: u32,
    /// By leaf and cell; [`EMPTY`] for the sky.
    nodes: Vec<u32>,
}

impl Views {
    pub(super) fn new(turn: f32, mut keys: Vec<u32>) -> Self {
        keys.par_chunks_exact_mut(CELLS.len()).with_min_len(64).for_each(|keys| {
            let closed = closed(keys);
            keys.copy_from_slice(&closed);
        });
        Self::of_nodes(turn, 0, keys)
    }

    /// Of nodes by leaf and cell, with holes closed already. Where they do not begin with the first leaf, they can be looked up, and
    /// not be gathered.
    pub fn of_nodes(turn: f32, first_leaf: u32, nodes: Vec<u32>) -> Self {
        Self { turn: turn.to_bits(), first_leaf, nodes }
    }

    /// These views of the bins of `still`, where the nearer of `moved` come before them. Leaves that see nothing new keep what they
    /// have.
    pub(super) fn with_nearer(&self, still: &Bins, moved: &Bins) -> Self {
        let mut views = self.clone();
        views.nodes.par_chunks_exact_mut(CELLS.len()).enumerate().with_min_len(64).for_each(|(leaf, nodes)| {
            let (still, moved) = (still.of_leaf(leaf as u32), moved.of_leaf(leaf as u32));
            if still.iter().zip(moved).any(|(still, moved)| moved < still) {
                let nearer: [u32; CELLS.len()] = std::array::from_fn(|cell| still[cell].min(moved[cell]));
                nodes.copy_from_slice(&closed(&nearer));
            }
        });
        views
    }

    /// Takes the views of others for the leaves from `first` on.
    pub(super) fn replace(&mut self, first: u32, others: &Self) {
        let first = first as usize * CELLS.len();
        self.nodes[first..first + others.nodes.len()].copy_from_slice(&others.nodes);
    }

    /// The nodes that a leaf sees, cell by cell; [`EMPTY`] where it sees the sky.
    pub fn of_leaf(&self, leaf: u32) -> &[u32] {
        let first = (leaf - self.first_leaf) as usize * CELLS.len();
        &self.nodes[first..first + CELLS.len()]
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.nodes.len() / CELLS.len()
    }

    /// The part of the hemisphere, by cosine, in which a leaf sees the sky.
    pub fn share_of_sky(&self, leaf: u32) -> f32 {
        let empty = self.of_leaf(leaf).iter().filter(|&&node| node == EMPTY).count();
        empty as f32 / CELLS.len() as f32
    }

    /// Unit directions in the world of the cells of a leaf.
    pub fn directions(&self, forest: &DiscForest, leaf: u32) -> impl Iterator<Item = Vec3> + use<> {
        let frame = frame_of(&forest.discs()[leaf as usize], f32::from_bits(self.turn));
        CELL_DIRECTIONS.iter().map(move |&direction| frame * direction)
    }
}

/// The nodes of keys, with holes closed.
fn closed(keys: &[u32]) -> [u32; CELLS.len()] {
    std::array::from_fn(|cell| match keys[cell] {
        EMPTY => nearest_around(keys, cell).map_or(EMPTY, node_of),
        key => node_of(key),
    })
}

/// The nearest of the neighbours of a hole; `None` for an opening.
fn nearest_around(keys: &[u32], cell: usize) -> Option<u32> {
    let side = CELLS.side as isize;
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
        let mut keys: Vec<u32> = (0..CELLS.len() as u32).map(|cell| (1 + cell % 7) << 20 | cell).collect();
        open.iter().for_each(|&cell| keys[cell] = EMPTY);
        Views::new(0.0, keys)
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
