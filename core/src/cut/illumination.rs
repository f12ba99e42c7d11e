//! Illumination cuts: the nodes of the light tree to which the light must be resolved (paper, 3.2).
//!
//! Phase one splits clusters whose error exceeds a bound. Phase two splits the node of highest intensity until it has
//! spent the budget, because "accounting for important, bright lights" matters more than a low error elsewhere. The cut
//! stores no values: the merge reads radiance from the tree, at the node where it arrives.

use super::packed::pack_node;
use std::{cmp::Reverse, collections::BinaryHeap};

/// Accuracy of an illumination cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IlluminationCriterion {
    /// Largest number of nodes; the paper uses 128 to 512.
    pub max_nodes: u32,
    /// Largest share of the budget for the error bound, 0 to 1; the rest refines by intensity.
    pub error_share: f32,
    /// Clusters whose `|C| var(L)` exceeds this fraction of `Σ L²` are split in the first phase.
    pub relative_error: f32,
}

impl IlluminationCriterion {
    /// The default criterion with a budget of `max_nodes`.
    pub fn with_budget(max_nodes: u32) -> Self {
        Self { max_nodes, error_share: 0.25, relative_error: 1e-3 }
    }
}

/// The illumination cut of a tree whose nodes have `means` and mean squares `means_sq` of their leaves' intensities: packed
/// nodes, left to right, whose values are zero.
pub fn intensity_cut(means: &[f32], means_sq: &[f32], criterion: IlluminationCriterion) -> Vec<u16> {
    let leaves = means.len() / 2;
    let budget = (criterion.max_nodes as usize).clamp(1, leaves);
    let mut split = vec![false; leaves];
    let bound = criterion.relative_error * means_sq[1] * leaves as f32;
    let size = |node: usize| (leaves >> node.ilog2()) as f32;
    let error = |node: usize| size(node) * (means_sq[node] - means[node] * means[node]).max(0.0);
    let intensity = |node: usize| size(node) * means[node];
    let by_error = 1 + ((budget - 1) as f32 * criterion.error_share) as usize;
    let count = refine(&mut split, 1, by_error, |node| if error(node) > bound { error(node) } else { 0.0 });
    refine(&mut split, count, budget, intensity);
    emit(&split)
}

/// Splits nodes of highest `priority` until the cut has `budget` nodes; nodes of priority 0 stay. Returns its size.
fn refine(split: &mut [bool], mut count: usize, budget: usize, priority: impl Fn(usize) -> f32) -> usize {
    let leaves = split.len();
    let mut queue = BinaryHeap::new();
    let enqueue = |queue: &mut BinaryHeap<_>, node: usize| {
        let p = priority(node);
        if node < leaves && p > 0.0 {
            queue.push((p.to_bits(), Reverse(node)));
        }
    };
    cut_nodes(split).for_each(|node| enqueue(&mut queue, node));
    while count < budget {
        let Some((_, Reverse(node))) = queue.pop() else { break };
        split[node] = true;
        count += 1;
        enqueue(&mut queue, 2 * node);
        enqueue(&mut queue, 2 * node + 1);
    }
    count
}

/// Heap indices of the nodes of the cut, left to right.
fn cut_nodes(split: &[bool]) -> impl Iterator<Item = usize> {
    let split = split.to_vec();
    let mut stack = vec![1_usize];
    std::iter::from_fn(move || {
        while let Some(node) = stack.pop() {
            if node >= split.len() || !split[node] {
                return Some(node);
            }
            stack.extend([2 * node + 1, 2 * node]);
        }
        None
    })
}

fn emit(split: &[bool]) -> Vec<u16> {
    cut_nodes(split).map(|node| pack_node(node.ilog2(), 0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        cut::packed::{cut_len, depth},
        light_tree::means_up_the_tree,
    };

    /// The cut of 256 leaves with one bright leaf, 77.
    fn cut_with(budget: u32) -> Vec<u16> {
        let mut leaves = vec![0.1_f32; 256];
        leaves[77] = 500.0;
        let squares: Vec<f32> = leaves.iter().map(|l| l * l).collect();
        let criterion = IlluminationCriterion::with_budget(budget);
        intensity_cut(&means_up_the_tree(&leaves), &means_up_the_tree(&squares), criterion)
    }

    #[test]
    fn the_budget_is_used_and_never_exceeded() {
        for budget in [1, 2, 17, 256, 9999] {
            let cut = cut_with(budget);
            assert_eq!(cut.len(), (budget as usize).min(256));
            assert_eq!(cut_len(8, &cut), Ok(cut.len()));
        }
    }

    #[test]
    fn a_bright_leaf_is_isolated_first() {
        let cut = cut_with(12);
        let mut first = 0;
        let of_bright = cut.iter().find(|&&n| {
            first += 256 >> depth(n);
            first > 77
        });
        assert_eq!(of_bright.map(|&n| depth(n)), Some(8));
        let too_small = cut_with(4);
        assert!(too_small.iter().all(|&n| depth(n) < 8), "negative control: four nodes cannot reach a leaf");
    }
}
