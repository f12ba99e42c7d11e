//! The key in a bin: a number that increases with the distance of its node.

use crate::implicit::disc_forest::DiscForest;

/// Key of an empty bin.
pub const EMPTY: u32 = u32::MAX;
/// Bits of the node's number; the 12 bits above them are the code of its distance.
pub(super) const NODE_BITS: u32 = 20;
/// Largest number of nodes with empty slots: the last number with the last code is [`EMPTY`].
const MOST_NODES: usize = (1 << NODE_BITS) - 1;
pub(super) const LARGEST_CODE: u32 = (1 << (32 - NODE_BITS)) - 1;
/// Dropped bits of an `f32`: 7 bits of the mantissa stay, 128 steps per doubling of a squared distance.
pub(super) const DROPPED: u32 = 16;
/// Distance with the largest code, in diagonals of the forest. Codes go down to 2^-16 of it.
const FARTHEST: f32 = 8.0;

/// Codes of squared distances, logarithmic in steps of 0.3 to 0.4 %. Smaller and larger distances get the first and last code.
#[derive(Clone, Copy, Debug)]
pub struct DistanceCodes {
    /// Factor of squared distances, in 1/m².
    scale: f32,
}

impl DistanceCodes {
    /// The codes of a forest, which stay when it moves.
    pub fn of(forest: &DiscForest) -> Self {
        let nodes = forest.shape().nodes();
        assert!(nodes <= MOST_NODES, "{nodes} nodes; keys have room for {MOST_NODES}");
        let farthest = FARTHEST * forest.diagonal();
        Self { scale: 1.0 / (farthest * farthest).max(f32::MIN_POSITIVE) }
    }

    /// Factor of squared distances, in 1/m².
    pub fn scale(self) -> f32 {
        self.scale
    }

    /// The key of a node at a squared distance in m².
    #[inline(always)]
    pub fn key(self, distance_sq: f32, node: u32) -> u32 {
        const LAST: u32 = 1.0_f32.to_bits() >> DROPPED;
        let code = (LARGEST_CODE + ((distance_sq * self.scale).to_bits() >> DROPPED)).saturating_sub(LAST);
        code.min(LARGEST_CODE) << NODE_BITS | node
    }

    /// The distance of a key in meters, to a step.
    pub fn distance(self, key: u32) -> f32 {
        let step = (1.0_f32.to_bits() >> DROPPED) + (key >> NODE_BITS) - LARGEST_CODE;
        (f32::from_bits(step << DROPPED | 1 << (DROPPED - 1)) / self.scale).sqrt()
    }
}

/// The node of a key.
#[inline(always)]
pub fn node_of(key: u32) -> u32 {
    key & ((1 << NODE_BITS) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearer_nodes_have_smaller_keys_down_to_a_step() {
        let codes = DistanceCodes { scale: 1.0 / 256.0 };
        let distances: Vec<f32> = (0..1000).map(|i| 1e-3 * 1.0092_f32.powi(i)).collect();
        let keys: Vec<u32> = distances.iter().map(|d| codes.key(d * d, 5)).collect();
        assert!(keys.is_sorted_by(|a, b| a < b), "each farther by 0.9 %");
        for (distance, &key) in distances.iter().zip(&keys) {
            assert!((codes.distance(key) / distance - 1.0).abs() < 2.5e-3 && node_of(key) == 5);
        }
        assert_eq!(codes.key(1.0, 5), codes.key(1.001, 5), "negative control: a step has a width");
    }

    #[test]
    fn what_is_too_near_or_too_far_is_clamped() {
        let codes = DistanceCodes { scale: 1.0 };
        assert_eq!(codes.key(0.0, 3), 3);
        assert_eq!(codes.key(1e30, 3), LARGEST_CODE << NODE_BITS | 3);
        assert_eq!(codes.key(f32::INFINITY, 3), codes.key(1e30, 3));
        assert!(codes.key(1e30, MOST_NODES as u32 - 1) < EMPTY);
    }
}
