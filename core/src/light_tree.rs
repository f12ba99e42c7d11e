//! The light tree: a complete binary tree over `N = 2^H` light samples (paper, 3.2 and 3.4).
//!
//! Because the tree is complete, a node is the dyadic interval `[a, a + 2^h)` of leaves in tree order. Its *heap
//! index* is `(N + a) >> h`: the root is 1, the children of `i` are `2i` and `2i + 1`, the leaves `N..2N`. Node arrays
//! are indexed by it; entry 0 is unused.

mod build;
mod features;
mod nearest;
mod node_light;
mod radiance;

pub use build::{cluster_order, cluster_order_of_groups};
pub use features::{Features, PilotVisibility};
pub use nearest::NearestLeaf;
pub use node_light::NodeLight;
pub use radiance::{EnvironmentSampler, GridEnergy, GridShift};

use crate::sphere::fibonacci_directions;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Greatest height: depths are stored in 4 bits.
pub const MAX_HEIGHT: u32 = 15;

/// Metric by which the tree is clustered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TreeKind {
    /// Distance of the samples alone (Eq. 10).
    Geometric,
    /// Distance of their pilot visibility vectors alone (Eq. 11).
    DataDriven,
    /// Both, weighted by `beta` (Eq. 12).
    #[default]
    Mixed,
}

/// A number of light samples that cannot form a tree.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("{0} light samples do not form a complete binary tree; use a power of two from 2 to 32768")]
pub struct LightCountError(pub usize);

/// A complete binary tree over distant light samples.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTree {
    /// `order[leaf]` is the index of the sample, a permutation of `0..N`.
    order: Vec<u32>,
    /// Unit direction of each leaf, in tree order.
    leaf_directions: Vec<Vec3>,
    /// Mean of the leaf directions below each node, by heap index. Its length grows as the directions cluster.
    mean_directions: Vec<Vec3>,
    /// Half-angle in radians of the cone that contains most of a node's directions, by heap index.
    radii: Vec<f32>,
}

/// Checks that `lights` is `2^H` with `1 <= H <= 15` and returns `H`.
///
/// # Errors
/// Any other number.
pub fn height_of(lights: usize) -> Result<u32, LightCountError> {
    let height = lights.checked_ilog2().unwrap_or(0);
    if lights.is_power_of_two() && (1..=MAX_HEIGHT).contains(&height) {
        Ok(height)
    } else {
        Err(LightCountError(lights))
    }
}

/// Whether `order` contains each of its indices once.
pub fn is_permutation(order: &[u32]) -> bool {
    let mut seen = vec![false; order.len()];
    order.iter().all(|&s| seen.get_mut(s as usize).is_some_and(|x| !std::mem::replace(x, true)))
}

impl LightTree {
    /// Clusters spherical Fibonacci samples top down, one per feature vector.
    ///
    /// # Errors
    /// A number of samples that is not `2^H`, `1 <= H <= 15`.
    pub fn build(features: &Features) -> Result<Self, LightCountError> {
        height_of(features.len())?;
        Self::from_order(cluster_order(features))
    }

    /// A tree over Fibonacci samples, clustered by direction alone.
    ///
    /// # Errors
    /// A number of samples that is not `2^H`, `1 <= H <= 15`.
    pub fn geometric(lights: usize) -> Result<Self, LightCountError> {
        height_of(lights)?;
        Self::build(&Features::geometric(&fibonacci_directions(lights)))
    }

    /// The tree whose leaves are the Fibonacci samples `order`, as stored in a dataset.
    ///
    /// # Errors
    /// A number of samples that is not `2^H`, `1 <= H <= 15`. `order` must be a permutation.
    pub fn from_order(order: Vec<u32>) -> Result<Self, LightCountError> {
        let n = order.len();
        height_of(n)?;
        let samples = fibonacci_directions(n);
        let leaf_directions: Vec<Vec3> = order.iter().map(|&s| samples[s as usize]).collect();
        let mean_directions = means_up_the_tree(&leaf_directions);
        let radii = mean_directions.iter().map(|d| radius(d.length(), n)).collect();
        Ok(Self { order, leaf_directions, mean_directions, radii })
    }

    /// Number of leaves, `N`.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Always false: the smallest tree has two leaves.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Height `H`: the root is `H` levels above the leaves.
    pub fn height(&self) -> u32 {
        self.len().ilog2()
    }

    /// Sample index of each leaf.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Unit direction of each leaf.
    pub fn leaf_directions(&self) -> &[Vec3] {
        &self.leaf_directions
    }

    /// Mean of the leaf directions of a node, by heap index; not unit.
    pub fn mean_directions(&self) -> &[Vec3] {
        &self.mean_directions
    }

    /// Half-angle in radians of the cone that contains most of a node's directions, by heap index.
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// Solid angle of one sample in steradians, `4π / N`.
    pub fn leaf_solid_angle(&self) -> f32 {
        crate::sphere::SPHERE / self.len() as f32
    }
}

/// Half-angle of the cap whose directions have a mean of length `resultant`; at least the half-angle of one leaf.
fn radius(resultant: f32, lights: usize) -> f32 {
    // A cap between cos θ and 1 has its centroid at (1 + cos θ) / 2.
    let cap = |r: f32| (2.0 * r - 1.0).clamp(-1.0, 1.0).acos();
    cap(resultant.min(1.0 - 1.0 / lights as f32))
}

/// Means of leaf values for every node, by heap index (entry 0 repeats the root). `leaves.len()` is a power of two.
pub fn means_up_the_tree<T>(leaves: &[T]) -> Vec<T>
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    let n = leaves.len();
    let mut nodes = vec![leaves[0]; 2 * n];
    nodes[n..].copy_from_slice(leaves);
    for i in (1..n).rev() {
        nodes[i] = (nodes[2 * i] + nodes[2 * i + 1]) * 0.5;
    }
    nodes[0] = nodes[1];
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_powers_of_two_up_to_32768_make_a_tree() {
        assert_eq!(height_of(32_768), Ok(15));
        assert_eq!(height_of(2), Ok(1));
        for bad in [0, 1, 3, 1000, 65_536] {
            assert_eq!(height_of(bad), Err(LightCountError(bad)));
        }
    }

    #[test]
    fn a_geometric_tree_is_a_permutation_with_tight_nodes() {
        let tree = LightTree::geometric(1024).unwrap();
        let mut sorted = tree.order().to_vec();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &s)| i == s as usize));
        // 16 of 1024 samples cover 0.196 sr, a cap of 14.3 degrees. No mean is longer than the cap's.
        let tightness = |t: &LightTree| (64..128).map(|i| t.mean_directions()[i].length()).sum::<f32>() / 64.0;
        assert!(tightness(&tree) > 0.975);
        let shuffled = LightTree::from_order((0..1024).map(|i| i * 389 % 1024).collect()).unwrap();
        assert!(tightness(&shuffled) < 0.9);
    }

    #[test]
    fn radius_of_nodes_is_that_of_caps_of_their_solid_angle() {
        let tree = LightTree::geometric(4096).unwrap();
        for (level, tolerance) in [(6, 0.25), (9, 0.25), (12, 0.02)] {
            let expected = (1.0 - 2.0 / (1_u32 << level) as f32).acos(); // cap of solid angle 4π / 2^level
            let nodes = 1_usize << level..2 << level;
            let mean = nodes.clone().map(|i| tree.radii()[i]).sum::<f32>() / nodes.len() as f32;
            assert!((mean / expected - 1.0).abs() < tolerance, "level {level}: {mean} for {expected}");
        }
    }

    #[test]
    fn means_are_means_of_the_leaves_below() {
        let leaves: Vec<f32> = (0..8).map(|i| (i * i) as f32).collect();
        let nodes = means_up_the_tree(&leaves);
        assert_eq!(nodes[1], 17.5);
        assert_eq!(nodes[3], (16 + 25 + 36 + 49) as f32 / 4.0);
    }
}
