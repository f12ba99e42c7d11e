//! The leaf whose light sample is nearest to a direction.

use super::{
    LightTree,
    radiance::fibonacci::{FibonacciLattice, Longitude},
};
use glam::Vec3;

/// Finds leaves by direction.
pub struct NearestLeaf {
    lattice: FibonacciLattice,
    leaf_of_sample: Vec<u32>,
}

impl NearestLeaf {
    /// An index over the leaves of a tree.
    pub fn new(tree: &LightTree) -> Self {
        let mut leaf_of_sample = vec![0; tree.len()];
        for (leaf, &sample) in tree.order().iter().enumerate() {
            leaf_of_sample[sample as usize] = leaf as u32;
        }
        Self { lattice: FibonacciLattice::new(tree.len()), leaf_of_sample }
    }

    /// The leaf nearest to a unit direction.
    pub fn leaf(&self, direction: Vec3) -> usize {
        let longitude = Longitude::new(f64::from(direction.x).atan2(direction.z.into()));
        // A pole itself has no zone.
        let height = f64::from(direction.y).clamp(-1.0 + 1e-9, 1.0 - 1e-9);
        self.leaf_of_sample[self.lattice.zone(height).nearest(&longitude) as usize] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_leaf_is_nearest_to_its_own_direction_and_poles_have_a_leaf() {
        let tree = LightTree::geometric(1024).unwrap();
        let nearest = NearestLeaf::new(&tree);
        for (leaf, &direction) in tree.leaf_directions().iter().enumerate() {
            assert_eq!(nearest.leaf(direction), leaf);
        }
        for pole in [Vec3::Y, Vec3::NEG_Y] {
            assert!(tree.leaf_directions()[nearest.leaf(pole)].dot(pole) > 0.99);
        }
    }
}
