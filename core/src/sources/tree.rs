//! The tree over surface sources: position and extent of each node.
//!
//! The tree is complete and its arrays are indexed by heap index, as in the light tree. A node's sources are discs;
//! from a large distance they are one light at their mean position.

use super::Source;
use glam::Vec3;
use std::f32::consts::TAU;

/// A complete binary tree over surface sources, in the order of its leaves. Arrays are by heap index.
#[derive(Clone, Debug)]
pub struct SourceTree {
    sources: Vec<Source>,
    areas: Vec<f32>,
    centers: Vec<Vec3>,
    radii: Vec<f32>,
}

impl SourceTree {
    /// The tree with `2^H` sources as leaves.
    pub fn new(sources: &[Source]) -> Self {
        assert!(sources.len().is_power_of_two(), "a complete tree");
        let clouds = Cloud::up_the_tree(sources.iter().map(|s| Cloud::disc(s, s.area)).collect());
        Self {
            sources: sources.to_vec(),
            areas: clouds.iter().map(|c| c.weight).collect(),
            centers: clouds.iter().map(|c| c.center).collect(),
            radii: clouds.iter().map(Cloud::radius).collect(),
        }
    }

    /// Number of leaves.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Always false: a tree has a leaf.
    pub fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    /// Height: the root is this many levels above the leaves.
    pub fn height(&self) -> u32 {
        self.len().ilog2()
    }

    /// The leaves.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Total area of a node's sources, in m².
    pub fn areas(&self) -> &[f32] {
        &self.areas
    }

    /// Mean position of a node's sources, weighted by area.
    pub fn centers(&self) -> &[Vec3] {
        &self.centers
    }

    /// Radius in meters of the disc whose points have the same mean squared distance from its center as a node's points.
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }
}

/// Weighted points: their weight, mean and mean squared distance from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cloud {
    pub weight: f32,
    pub center: Vec3,
    pub variance: f32,
}

impl Cloud {
    /// The points of a source's disc.
    pub fn disc(source: &Source, weight: f32) -> Self {
        Self { weight, center: source.surfel.position, variance: source.area / TAU }
    }

    /// Joins both, without the cancellation of sums of squares (Chan et al. 1979). If neither has weight, each counts half.
    fn joined(self, other: Self) -> Self {
        let weight = self.weight + other.weight;
        let share = if weight > 0.0 { other.weight / weight } else { 0.5 };
        let between = other.center - self.center;
        let spread = between.length_squared() * share * (1.0 - share);
        Self {
            weight,
            center: self.center + between * share,
            variance: self.variance + (other.variance - self.variance) * share + spread,
        }
    }

    /// Clouds of all nodes by heap index (entry 0 repeats the root), from the leaves' clouds.
    pub fn up_the_tree(leaves: Vec<Self>) -> Vec<Self> {
        let n = leaves.len();
        let mut nodes = leaves.clone();
        nodes.extend(leaves);
        for i in (1..n).rev() {
            nodes[i] = nodes[2 * i].joined(nodes[2 * i + 1]);
        }
        nodes[0] = nodes[1];
        nodes
    }

    /// See [`SourceTree::radii`]: the mean squared distance of a disc is half of its squared radius.
    pub fn radius(&self) -> f32 {
        (2.0 * self.variance).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::square_of_sources;

    #[test]
    fn nodes_have_the_area_centre_and_radius_of_their_part_of_the_square() {
        let tree = SourceTree::new(&square_of_sources(5, 1.0));
        assert_eq!((tree.len(), tree.height()), (1024, 10));
        assert!((tree.areas()[1] - 4.0).abs() < 1e-4);
        assert!((tree.centers()[1] - Vec3::new(100.0, 0.0, 100.0)).length() < 1e-4);
        // Points of a square of side s lie sqrt(s² / 6) from its center on the mean square.
        for (node, side) in [(1, 2.0_f32), (4, 1.0), (64, 0.25)] {
            let expected = (side * side / 3.0).sqrt();
            assert!((tree.radii()[node] / expected - 1.0).abs() < 0.01, "{}", tree.radii()[node]);
        }
        let mut swapped = square_of_sources(5, 1.0);
        swapped.swap(0, 1023);
        assert!(SourceTree::new(&swapped).radii()[64] > 0.5, "negative control");
    }

    #[test]
    fn sources_without_area_make_no_nan() {
        let mut sources = square_of_sources(2, 1.0);
        sources.iter_mut().for_each(|s| s.area = 0.0);
        let tree = SourceTree::new(&sources);
        assert!(tree.centers().iter().all(|c| c.is_finite()) && tree.radii().iter().all(|r| r.is_finite()));
        assert!((tree.centers()[1].x - 100.0).abs() < 1e-4);
    }
}
