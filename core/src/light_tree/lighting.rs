//! What changes when the light changes: radiance and directions of all nodes of a light tree.

use super::{LightTree, means_up_the_tree};
use crate::color::luminance;
use glam::Vec3;

/// A light tree under one illumination; all arrays by heap index.
#[derive(Clone, Debug)]
pub struct Lighting {
    /// Mean radiance of the leaves below each node.
    pub radiance: Vec<Vec3>,
    /// Unit direction that represents each node: the mean of its leaves' directions, weighted by their luminance.
    ///
    /// In a cluster that contains a bright spot, the BRDF must be evaluated for the direction of the spot.
    pub direction: Vec<Vec3>,
    /// Inverse concentration `1 / kappa` of each node as a von Mises-Fisher lobe (Banerjee et al. 2005), with the same
    /// weights.
    pub inv_kappa: Vec<f32>,
    /// Mean squared luminance of the leaves below each node, for the error bound of illumination cuts.
    pub luminance_sq: Vec<f32>,
}

impl Lighting {
    /// Computes means up the tree from `leaf_radiance`, one value per leaf in tree order.
    pub fn new(tree: &LightTree, leaf_radiance: &[Vec3]) -> Self {
        assert_eq!(leaf_radiance.len(), tree.len(), "one radiance a leaf");
        let luminances: Vec<f32> = leaf_radiance.iter().map(|&l| luminance(l)).collect();
        let squares: Vec<f32> = luminances.iter().map(|l| l * l).collect();
        let weighted: Vec<Vec3> = tree.leaf_directions().iter().zip(&luminances).map(|(&d, &l)| d * l).collect();
        let (weighted, weight) = (means_up_the_tree(&weighted), means_up_the_tree(&luminances));
        let leaf_inv_kappa = leaf_inv_kappa(tree.len());
        let nodes = 0..2 * tree.len();
        let mean = |i: usize| {
            let plain = tree.mean_directions()[i];
            // Dark nodes contribute nothing; any direction inside them will do.
            if weight[i] > 0.0 { weighted[i] / weight[i] } else { plain }
        };
        Self {
            radiance: means_up_the_tree(leaf_radiance),
            direction: nodes.clone().map(|i| mean(i).normalize_or(Vec3::Y)).collect(),
            inv_kappa: nodes.map(|i| inv_kappa(mean(i).length()) + leaf_inv_kappa).collect(),
            luminance_sq: means_up_the_tree(&squares),
        }
    }
}

/// `1 / kappa` with `kappa = R (3 - R²) / (1 - R²)` for a mean resultant of length `R` (Banerjee et al. 2005, Eq. 4.4).
fn inv_kappa(resultant: f32) -> f32 {
    let r = resultant.clamp(1e-4, 1.0);
    ((1.0 - r * r) / (r * (3.0 - r * r))).max(0.0)
}

/// A leaf is itself a small cap of solid angle `4π / N`: the spread that its sample stands for.
fn leaf_inv_kappa(lights: usize) -> f32 {
    inv_kappa(1.0 - 1.0 / lights as f32) // the centroid of a cap of height h = 2 / N lies at 1 - h / 2
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
        let lighting = Lighting::new(&tree, &leaves);
        assert!(lighting.direction[1].dot(tree.leaf_directions()[5]) > 0.999);
        let energy: Vec3 = leaves.iter().sum::<Vec3>() * (SPHERE / 64.0);
        assert!((lighting.radiance[1] * SPHERE - energy).length() < 1e-2 * energy.length());
    }
}
