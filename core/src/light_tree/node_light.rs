//! The illumination of a tree of lights: radiance, place and spread of every node.

use super::{LightTree, means_up_the_tree};
use crate::color::luminance;
use glam::Vec3;
use rayon::prelude::*;

/// A tree of lights under one illumination; all arrays by heap index.
#[derive(Clone, Debug)]
pub struct NodeLight {
    /// Mean radiance of the leaves below each node; surface sources are weighted by area. Their cuts hold solid angles,
    /// which are proportional to area, so the product of both means is close to the mean of the product.
    pub radiance: Vec<Vec3>,
    /// Where the light of each node comes from, weighted by luminance: a mean unit direction, or a mean position in
    /// meters for surface sources. The BRDF of a cluster with a bright spot must be evaluated for that spot.
    pub place: Vec<Vec3>,
    /// How far the light spreads around its place, with the same weights: the inverse concentration `1 / kappa` as a von
    /// Mises-Fisher lobe (Banerjee et al. 2005), or a radius in meters.
    pub spread: Vec<f32>,
    /// Mean intensity of the leaves below each node, for illumination cuts: luminance, times area for surface sources.
    pub intensity: Vec<f32>,
    /// Mean squared intensity of the leaves below each node.
    pub intensity_sq: Vec<f32>,
}

impl NodeLight {
    /// Computes means up a tree of distant lights from `leaf_radiance`, one value per leaf in tree order.
    pub fn distant(tree: &LightTree, leaf_radiance: &[Vec3]) -> Self {
        assert_eq!(leaf_radiance.len(), tree.len(), "one radiance a leaf");
        let luminances: Vec<f32> = leaf_radiance.iter().map(|&l| luminance(l)).collect();
        let squares: Vec<f32> = luminances.iter().map(|l| l * l).collect();
        let weighted: Vec<Vec3> = tree.leaf_directions().iter().zip(&luminances).map(|(&d, &l)| d * l).collect();
        let of_directions = || (means_up_the_tree(&weighted), means_up_the_tree(&luminances));
        let of_radiance = || (means_up_the_tree(leaf_radiance), means_up_the_tree(&squares));
        let ((weighted, weight), (radiance, intensity_sq)) = rayon::join(of_directions, of_radiance);
        let leaf_spread = Self::leaf_spread(tree.len());
        let nodes = (0..2 * tree.len()).into_par_iter().with_min_len(1024);
        let mean = |i: usize| {
            let plain = tree.mean_directions()[i];
            // Dark nodes contribute nothing; any direction inside them will do.
            if weight[i] > 0.0 { weighted[i] / weight[i] } else { plain }
        };
        Self {
            intensity: radiance.iter().map(|&l| luminance(l)).collect(),
            radiance,
            place: nodes.clone().map(|i| mean(i).normalize_or(Vec3::Y)).collect(),
            spread: nodes.map(|i| inv_kappa(mean(i).length()) + leaf_spread).collect(),
            intensity_sq,
        }
    }

    /// Spread of one of so many distant lights. A leaf is itself a small cap of solid angle `4π / N`.
    pub fn leaf_spread(lights: usize) -> f32 {
        inv_kappa(1.0 - 1.0 / lights as f32) // the centroid of a cap of height h = 2 / N lies at 1 - h / 2
    }
}

/// `1 / kappa` with `kappa = R (3 - R²) / (1 - R²)` for a mean resultant of length `R` (Banerjee et al. 2005, Eq. 4.4).
fn inv_kappa(resultant: f32) -> f32 {
    let r = resultant.clamp(1e-4, 1.0);
    ((1.0 - r * r) / (r * (3.0 - r * r))).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::SPHERE;

    #[test]
    fn directions_lean_to_the_bright_leaf() {
        let tree = LightTree::geometric(64).unwrap();
        let mut leaves = vec![Vec3::splat(0.01); 64];
        leaves[5] = Vec3::splat(1000.0);
        let lighting = NodeLight::distant(&tree, &leaves);
        assert!(lighting.place[1].dot(tree.leaf_directions()[5]) > 0.999);
        let energy: Vec3 = leaves.iter().sum::<Vec3>() * (SPHERE / 64.0);
        assert!((lighting.radiance[1] * SPHERE - energy).length() < 1e-2 * energy.length());
    }
}
