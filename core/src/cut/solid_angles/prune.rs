//! Coarsening of stored source cuts, so that they fit into a texture.

use super::{
    SourceCriterion,
    code::{LARGEST_SOLID_ANGLE, solid_angle, solid_angle_code},
};
use crate::cut::packed::{VALUE_MAX, depth};

/// Coarsens a packed cut of solid angles of `2^height` sources. A node that meets `criterion`, by the stored values, replaces all
/// nodes below it. The stored values have lost detail, so a cut selected by `criterion` from the leaves may be longer.
pub fn prune_sources(height: u32, criterion: SourceCriterion, cut: &[u16]) -> Vec<u16> {
    let unit = LARGEST_SOLID_ANGLE / (1_u32 << height) as f32;
    let mut pruned = Vec::with_capacity(cut.len());
    let mut done: Vec<Node> = Vec::with_capacity(2 * height as usize);
    let mut end = 0_u32;
    for &packed in cut {
        let size = 1_u32 << (height - depth(packed));
        let sum = size as f32 * solid_angle(packed & VALUE_MAX) / unit;
        done.push(Node { size, sum, error: 0.0, first: pruned.len() });
        pruned.push(packed);
        end += size;
        while let [.., left, right] = &done[..]
            && left.size == right.size
            && end.is_multiple_of(2 * right.size)
        {
            let parent = left.parent_with(right);
            done.truncate(done.len() - 2);
            if !criterion.splits(parent.size as f32, parent.sum, parent.error, unit) {
                pruned.truncate(parent.first);
                pruned.push(parent.packed(height, unit));
            }
            done.push(parent);
        }
    }
    pruned
}

/// A node of the tree whose leaves have all been visited.
struct Node {
    /// Number of its leaves.
    size: u32,
    /// Sum of their values, in units of 2π/N.
    sum: f32,
    /// Squared error of their mean, estimated from the stored values.
    error: f32,
    /// Index of its first node in the shorter cut.
    first: usize,
}

impl Node {
    fn parent_with(&self, sibling: &Self) -> Self {
        let (size, difference) = (2 * self.size, self.sum - sibling.sum);
        let error = self.error + sibling.error + difference * difference / size as f32;
        Self { size, sum: self.sum + sibling.sum, error, first: self.first }
    }

    fn packed(&self, height: u32, unit: f32) -> u16 {
        let depth = height - self.size.ilog2();
        solid_angle_code(self.sum * unit / self.size as f32) | (depth as u16) << 12
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::{
        packed::cut_len,
        solid_angles::test_cuts::{HEIGHT, expand, leaves, select},
    };

    const FINE: SourceCriterion = SourceCriterion { sigma: 0.5, max_solid_angle: 0.2, contrast: 0.1 };

    /// Root of the squared error over all leaves, in steradians.
    fn error(cut: &[u16], leaves: &[f32]) -> f32 {
        expand(cut).iter().zip(leaves).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    }

    #[test]
    fn coarsened_cuts_are_as_good_as_selected_ones_of_their_length() {
        for seed in 0..10 {
            let leaves = leaves(seed);
            let fine = select(FINE, &leaves);
            for factor in [2.0, 4.0, 8.0] {
                let coarser = FINE.coarser(factor);
                let (pruned, selected) = (prune_sources(HEIGHT, coarser, &fine), select(coarser, &leaves));
                assert_eq!(cut_len(HEIGHT, &pruned), Ok(pruned.len()));
                // Stored values are rounded, so nodes at a bound may fall to either side of it.
                assert!(pruned.len() < fine.len() && pruned.len() <= selected.len() + selected.len() / 20);
                let (found, wanted) = (error(&pruned, &leaves), error(&selected, &leaves));
                assert!(found < 1.4 * wanted, "{found} for {wanted}, {} nodes for {}", pruned.len(), selected.len());
            }
            let blind: Vec<f32> = leaves.chunks(64).flat_map(|c| vec![c.iter().sum::<f32>() / 64.0; 64]).collect();
            let (blind, found) =
                (select(FINE, &blind), error(&prune_sources(HEIGHT, FINE.coarser(2.0), &fine), &leaves));
            assert!(error(&blind, &leaves) > 1.4 * found, "negative control: nodes that know nothing of their leaves");
        }
    }

    #[test]
    fn nothing_is_lost_at_a_sigma_of_zero_and_light_is_kept_at_any() {
        let leaves = leaves(3);
        let fine = select(FINE, &leaves);
        let exact = SourceCriterion { sigma: 0.0, contrast: 0.0, ..FINE };
        assert_eq!(prune_sources(HEIGHT, exact, &fine), fine);
        let pruned = prune_sources(HEIGHT, FINE.coarser(1e4), &fine);
        let total = |cut: &[u16]| expand(cut).iter().sum::<f32>();
        assert!((total(&pruned) / total(&fine) - 1.0).abs() < 5e-3);
        assert!(pruned.iter().all(|&n| {
            let size = (1 << (HEIGHT - depth(n))) as f32;
            size == 1.0 || size * solid_angle(n & VALUE_MAX) < 0.2 * 1.01
        }));
    }
}
