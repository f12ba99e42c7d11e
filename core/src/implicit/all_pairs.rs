//! Links all surface elements to all, without a hierarchy (implicit visibility, 3.1): the reference for links of trees.

use super::{bins::CubeBins, links::Links};
use crate::implicit::{disc_forest::DiscForest, forest::quadtrees::Slot};
use glam::Vec3;

/// Distances in meters from a leaf to the nearest other leaf in each bin; infinite where there is none.
pub fn nearest(forest: &DiscForest, leaf: u32, bins: CubeBins) -> Vec<f32> {
    let from = forest.discs()[leaf as usize].position;
    let mut nearest = vec![f32::INFINITY; bins.len()];
    // Vertices at the leaf's position, such as itself, are not seen.
    for offset in forest.discs().iter().map(|disc| disc.position - from).filter(|offset| *offset != Vec3::ZERO) {
        let texel = bins.texel_of(offset);
        nearest[texel] = nearest[texel].min(offset.length());
    }
    nearest
}

impl Links {
    /// Share of wrong bins among the bins of every `step`-th leaf filled by both a link and a pair. A bin is wrong if
    /// the two distances differ by more than the sizes of both ends. All links are at the leaves.
    pub fn share_of_wrong(&self, forest: &DiscForest, step: usize) -> f32 {
        let (mut wrong, mut all) = (0, 0);
        for &node in forest.shape().leaf_nodes() {
            let Slot::Leaf(leaf) = forest.shape().slot(node) else { continue };
            if !(leaf as usize).is_multiple_of(step) {
                continue;
            }
            for (link, nearest) in self.of(node).iter().zip(nearest(forest, leaf, self.bins)) {
                if link.distance < f32::INFINITY && nearest < f32::INFINITY {
                    let size = 2.0 * (forest.node(link.node).radius + forest.node(node).radius);
                    wrong += usize::from((link.distance - nearest).abs() > size);
                    all += 1;
                }
            }
        }
        wrong as f32 / all.max(1) as f32
    }
}
