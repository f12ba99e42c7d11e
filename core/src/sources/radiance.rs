//! What changes with the light on the sources: radiance and centres of all nodes of a source tree.

use super::tree::{Cloud, SourceTree};
use crate::{color::luminance, light_tree::means_up_the_tree};
use glam::Vec3;

/// A source tree under one illumination; all arrays by heap index.
#[derive(Clone, Debug)]
pub struct SourceRadiance {
    /// Mean radiance of the sources below each node, weighted by area. A cut's value is a solid angle, which is
    /// proportional to area, so the product of both means is close to the mean of the product.
    pub radiance: Vec<Vec3>,
    /// Mean position, weighted by area and luminance: in a node that contains a bright spot, light comes from the spot.
    pub center: Vec<Vec3>,
    /// Radius in metres as [`SourceTree::radii`], with the same weights.
    pub spread: Vec<f32>,
    /// Mean of luminance times area of the leaves below each node, for illumination cuts.
    pub power: Vec<f32>,
    /// Mean of its square.
    pub power_sq: Vec<f32>,
}

impl SourceRadiance {
    /// Computes means up the tree from `leaf_radiance`, one value per source.
    pub fn new(tree: &SourceTree, leaf_radiance: &[Vec3]) -> Self {
        assert_eq!(leaf_radiance.len(), tree.len(), "one radiance a source");
        let leaves = || tree.sources().iter().zip(leaf_radiance);
        let power: Vec<f32> = leaves().map(|(s, &l)| luminance(l) * s.area).collect();
        let squares: Vec<f32> = power.iter().map(|p| p * p).collect();
        let discs = tree.sources().iter().zip(&power).map(|(s, &weight)| Cloud::disc(s, weight));
        let clouds = Cloud::up_the_tree(discs.collect());
        Self {
            radiance: means_by_area(tree, leaf_radiance),
            center: clouds.iter().map(|c| c.center).collect(),
            spread: clouds.iter().map(Cloud::radius).collect(),
            power: means_up_the_tree(&power),
            power_sq: means_up_the_tree(&squares),
        }
    }
}

fn means_by_area(tree: &SourceTree, leaves: &[Vec3]) -> Vec<Vec3> {
    let n = leaves.len();
    let mut nodes = [leaves, leaves].concat();
    for i in (1..n).rev() {
        let (left, right) = (tree.areas()[2 * i], tree.areas()[2 * i + 1]);
        let share = if left + right > 0.0 { right / (left + right) } else { 0.5 };
        nodes[i] = nodes[2 * i] + (nodes[2 * i + 1] - nodes[2 * i]) * share;
    }
    nodes[0] = nodes[1];
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::square_of_sources;

    #[test]
    fn radiance_is_weighted_by_area_and_centres_lean_to_the_bright_source() {
        let mut sources = square_of_sources(3, 1.0);
        sources[7].area *= 5.0;
        let tree = SourceTree::new(&sources);
        let mut radiance = vec![Vec3::splat(0.01); 64];
        radiance[7] = Vec3::splat(1000.0);
        let lit = SourceRadiance::new(&tree, &radiance);
        let area: f32 = sources.iter().map(|s| s.area).sum();
        let flux: f32 = sources.iter().zip(&radiance).map(|(s, l)| s.area * l.x).sum();
        assert!((lit.radiance[1].x * area / flux - 1.0).abs() < 1e-4);
        assert!((lit.radiance[1].x / 15.6 - 1.0).abs() > 0.5, "negative control: the plain mean is another");
        assert!(lit.center[1].distance(sources[7].surfel.position) < 1e-2);
        assert!(lit.spread[1] < 0.5 * tree.radii()[1], "{} of {}", lit.spread[1], tree.radii()[1]);
        assert!((lit.power[1] * 64.0 / flux - 1.0).abs() < 1e-4);
    }

    #[test]
    fn darkness_has_no_radiance_and_no_nan() {
        let tree = SourceTree::new(&square_of_sources(2, 1.0));
        let dark = SourceRadiance::new(&tree, &[Vec3::ZERO; 16]);
        assert!(dark.radiance.iter().all(|&l| l == Vec3::ZERO));
        assert!(dark.center.iter().all(|c| c.is_finite()));
        assert!(dark.power.iter().chain(&dark.power_sq).all(|&p| p == 0.0));
    }
}
