//! Values of leaves at vertices, by weights computed once.
//!
//! A vertex takes the four nearest leaves of its object, weighted like functions of the meshless basis (meshless paper,
//! Eq. 8 to 11). The weights belong to the baked mesh: leaves move with it, so the weights stay valid.

use crate::{
    implicit::{
        disc_forest::DiscForest,
        forest::{nodes::Disc, quadtrees::Slot},
    },
    sparse::SparseRows,
    surfel::distance::{alignment, kernel, same_layer, squashed_distance},
    transport::Coefficient,
};
use glam::Vec3;
use rayon::prelude::*;

/// Leaves per vertex.
const NEAREST: usize = 4;
/// Radius of the kernel in distances of the farthest leaf, which would have zero weight at 1.
const REACH: f32 = 1.5;
/// Smallest weight of a leaf that faces the vertex at all: an edge may lie at right angles to all its faces.
const LEAST: f32 = 1e-4;

/// A point of an object that receives light from its leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Index of the object.
    pub object: u32,
    /// Position as baked, in meters.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

/// Weights of leaves at vertices, or at any other points.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexWeights {
    rows: SparseRows,
}

impl VertexWeights {
    /// Weights for receivers on a forest as baked. `None`, and a receiver whose object has no leaves, gets nothing.
    pub fn new(forest: &DiscForest, receivers: &[Option<Receiver>]) -> Self {
        let rows = SparseRows::build(receivers.len(), |row, out| {
            if let Some(receiver) = &receivers[row] {
                let nearest = Nearest::of(forest, receiver);
                out.extend(weights(forest, receiver, &nearest));
            }
        });
        Self { rows }
    }

    /// Values at all receivers from the leaves' values.
    pub fn apply<T: Coefficient>(&self, leaves: &[T]) -> Vec<T> {
        (0..self.rows.len()).into_par_iter().with_min_len(1024).map(|row| self.rows.product(row, leaves)).collect()
    }

    /// Number of receivers.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no receivers.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The leaves of a receiver with weights that sum to one.
    pub fn row(&self, receiver: usize) -> &[(u32, f32)] {
        self.rows.row(receiver)
    }
}

/// The weights of the leaves found.
fn weights(forest: &DiscForest, receiver: &Receiver, nearest: &Nearest) -> Vec<(u32, f32)> {
    let radius = nearest.found.last().map_or(0.0, |last| REACH * last.0).max(f32::MIN_POSITIVE);
    let weight = |&(distance, leaf): &(f32, u32)| {
        let disc = &forest.discs()[leaf as usize];
        let layer = same_layer(receiver.position - disc.position, receiver.normal + disc.normal, radius);
        let facing = alignment(receiver.normal, disc.normal).max(LEAST);
        (leaf, kernel(distance / radius).max(LEAST) * layer * facing)
    };
    let mut all: Vec<(u32, f32)> = nearest.found.iter().map(weight).collect();
    let sum: f32 = all.iter().map(|w| w.1).sum();
    all.iter_mut().for_each(|w| w.1 /= sum);
    all
}

/// The nearest leaves so far, nearest first.
struct Nearest {
    found: Vec<(f32, u32)>,
}

impl Nearest {
    /// Finds them by descent of the tree of the receiver's object, nearer nodes first.
    fn of(forest: &DiscForest, receiver: &Receiver) -> Self {
        let mut nearest = Self { found: Vec::with_capacity(NEAREST + 1) };
        let mut waiting = vec![(0.0, receiver.object)];
        if forest.leaves_of(receiver.object).is_empty() {
            return nearest;
        }
        while let Some((least, node)) = waiting.pop() {
            if least > nearest.farthest() {
                continue;
            }
            match forest.shape().slot(node) {
                Slot::Empty => {}
                Slot::Leaf(leaf) => nearest.offer(distance(receiver, &forest.discs()[leaf as usize]), leaf),
                Slot::Inner(block) => {
                    let first = waiting.len();
                    let least = |node: u32| {
                        let bounds = forest.node(node);
                        (bounds.center.distance(receiver.position) - bounds.radius).max(0.0)
                    };
                    waiting.extend(forest.shape().nodes_of(block).map(|node| (least(node), node)));
                    waiting[first..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
                }
            }
        }
        nearest
    }

    /// Distance of the fourth leaf; infinite while there are fewer.
    fn farthest(&self) -> f32 {
        self.found.get(NEAREST - 1).map_or(f32::INFINITY, |f| f.0)
    }

    fn offer(&mut self, distance: f32, leaf: u32) {
        let place = self.found.partition_point(|f| (f.0, f.1) <= (distance, leaf));
        self.found.insert(place, (distance, leaf));
        self.found.truncate(NEAREST);
    }
}

/// Distance in meters by position and normal (meshless paper, Eq. 11). A leaf that faces away is farther than all
/// others, but is found if there are no others.
fn distance(receiver: &Receiver, disc: &Disc) -> f32 {
    let near = squashed_distance(disc.position, disc.normal, receiver.position);
    near / alignment(receiver.normal, disc.normal).max(LEAST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::tests::{Furnished, furnished};

    fn receivers(of: &Furnished) -> Vec<Option<Receiver>> {
        let mesh = &of.mesh;
        let corner = |(triangle, &object): (usize, &u32)| {
            let vertex = mesh.triangles[triangle][triangle % 3] as usize;
            Some(Receiver { object, position: mesh.positions[vertex], normal: mesh.normals[vertex] })
        };
        mesh.triangle_object.iter().enumerate().map(corner).collect()
    }

    #[test]
    fn the_four_nearest_leaves_of_the_object_are_those_of_brute_force() {
        let furnished = furnished(1024);
        let forest = furnished.forest.discs();
        let receivers = receivers(&furnished);
        let weights = VertexWeights::new(forest, &receivers);
        for (row, receiver) in receivers.iter().flatten().enumerate() {
            let leaves = forest.leaves_of(receiver.object);
            let mut all: Vec<(f32, u32)> =
                leaves.map(|i| (distance(receiver, &forest.discs()[i as usize]), i)).collect();
            all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let found: Vec<u32> = weights.row(row).iter().map(|w| w.0).collect();
            assert_eq!(found, all[..4].iter().map(|n| n.1).collect::<Vec<_>>(), "{receiver:?}");
            let sum: f32 = weights.row(row).iter().map(|w| w.1).sum();
            assert!((sum - 1.0).abs() < 1e-5 && weights.row(row).iter().all(|w| w.1 > 0.0));
        }
    }

    #[test]
    fn values_of_a_wall_do_not_show_on_the_next() {
        let furnished = furnished(2048);
        let forest = furnished.forest.discs();
        let receivers = receivers(&furnished);
        let on_floor: Vec<f32> = forest.discs().iter().map(|d| d.normal.y.max(0.0)).collect();
        let at_vertices = VertexWeights::new(forest, &receivers).apply(&on_floor);
        let of_room = || receivers.iter().flatten().zip(&at_vertices).filter(|(receiver, _)| receiver.object == 0);
        assert!(of_room().all(|(receiver, value)| (value - receiver.normal.y.max(0.0)).abs() < 0.02));
        assert!(of_room().any(|(_, value)| *value > 0.9), "and the floor has them");
    }

    #[test]
    fn an_object_without_leaves_takes_nothing() {
        let forest = DiscForest::new(&[0, 1], vec![Disc { position: Vec3::ZERO, normal: Vec3::Y, area: 1.0 }]);
        let at = |object| Some(Receiver { object, position: Vec3::X, normal: Vec3::Y });
        let weights = VertexWeights::new(&forest, &[at(0), at(1), None]);
        assert_eq!([0, 1, 2].map(|row| weights.row(row)), [&[][..], &[(0, 1.0)], &[]]);
    }
}
