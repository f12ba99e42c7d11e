//! The light of a source tree's nodes: radiance and position.

use super::tree::{Cloud, SourceTree};
use crate::{
    color::luminance,
    light_tree::{NodeLight, means_up_the_tree},
};
use glam::Vec3;

impl SourceTree {
    /// Computes means up the tree from `leaf_radiance`, one value per source.
    pub fn light(&self, leaf_radiance: &[Vec3]) -> NodeLight {
        assert_eq!(leaf_radiance.len(), self.len(), "one radiance a source");
        let leaves = || self.sources().iter().zip(leaf_radiance);
        let power: Vec<f32> = leaves().map(|(s, &l)| luminance(l) * s.area).collect();
        let squares: Vec<f32> = power.iter().map(|p| p * p).collect();
        let discs = self.sources().iter().zip(&power).map(|(s, &weight)| Cloud::disc(s, weight));
        let clouds = Cloud::up_the_tree(discs.collect());
        NodeLight {
            radiance: means_by_area(self, leaf_radiance),
            place: clouds.iter().map(|c| c.center).collect(),
            spread: clouds.iter().map(Cloud::radius).collect(),
            intensity: means_up_the_tree(&power),
            intensity_sq: means_up_the_tree(&squares),
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
        let lit = tree.light(&radiance);
        let area: f32 = sources.iter().map(|s| s.area).sum();
        let flux: f32 = sources.iter().zip(&radiance).map(|(s, l)| s.area * l.x).sum();
        assert!((lit.radiance[1].x * area / flux - 1.0).abs() < 1e-4);
        assert!((lit.radiance[1].x / 15.6 - 1.0).abs() > 0.5, "negative control: the plain mean is another");
        assert!(lit.place[1].distance(sources[7].surfel.position) < 1e-2);
        assert!(lit.spread[1] < 0.5 * tree.radii()[1], "{} of {}", lit.spread[1], tree.radii()[1]);
        assert!((lit.intensity[1] * 64.0 / flux - 1.0).abs() < 1e-4);
    }

    #[test]
    fn darkness_has_no_radiance_and_no_nan() {
        let tree = SourceTree::new(&square_of_sources(2, 1.0));
        let dark = tree.light(&[Vec3::ZERO; 16]);
        assert!(dark.radiance.iter().all(|&l| l == Vec3::ZERO));
        assert!(dark.place.iter().all(|c| c.is_finite()));
        assert!(dark.intensity.iter().chain(&dark.intensity_sq).all(|&p| p == 0.0));
    }
}
