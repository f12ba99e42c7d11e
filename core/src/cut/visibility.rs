//! Selection of visibility cuts (paper, 3.2, Eq. 5).

use super::{
    packed::{VALUE_MAX, depth, pack_node, value},
    renewal::CutPart,
};
use crate::ray::OPEN;
use serde::{Deserialize, Serialize};
use std::collections::BinaryHeap;

/// The value of a fully visible leaf.
const UNIT: f64 = OPEN as f64;

/// When a node of a visibility cut is fine enough.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutCriterion {
    /// Split while `|C| var > sigma²` (Eq. 5).
    pub sigma: f32,
    /// Largest number of nodes; the nodes of largest error are split first.
    pub max_nodes: u32,
    /// Total-error mode: stop when the sum of the nodes' squared errors is at most the square of this.
    pub total_error: Option<f32>,
}

impl Default for CutCriterion {
    fn default() -> Self {
        Self { sigma: 2.0, max_nodes: u32::MAX, total_error: None }
    }
}

impl CutCriterion {
    /// Whether a node of a tree of `leaves` leaves is split by its own leaves alone.
    pub fn is_local(&self, leaves: usize) -> bool {
        self.max_nodes as usize >= leaves && self.total_error.is_none()
    }

    fn splits(&self, error: f32) -> bool {
        error > self.sigma * self.sigma
    }

    /// The least squared error of a node of so many leaves that splits it, times the leaves, in units of 1 / [`OPEN`]².
    pub fn least_split(&self, leaves: u32) -> u64 {
        let all = u64::from(leaves) * u64::from(OPEN);
        let (mut least, mut end) = (0, all * all + 1);
        while least < end {
            let middle = least.midpoint(end);
            match self.splits(error_of(middle, leaves.into())) {
                true => end = middle,
                false => least = middle + 1,
            }
        }
        least
    }

    /// The criterion for leaves that each stand for `leaves` equal ones; it selects the same cuts.
    #[must_use]
    pub fn of_means(self, leaves: usize) -> Self {
        let scale = (leaves as f32).sqrt().recip();
        Self { sigma: self.sigma * scale, total_error: self.total_error.map(|error| error * scale), ..self }
    }
}

/// `|C| var` of a node of `leaves` leaves from so many times it, in units of 1 / [`OPEN`]².
fn error_of(times_leaves: u64, leaves: u64) -> f32 {
    (times_leaves as f64 / (leaves as f64 * UNIT * UNIT)) as f32
}

/// Selects cuts of functions on `2^height` leaves that are nearly all 0 or 1. Keeps its buffers between vertices.
pub struct CutSelector {
    height: u32,
    criterion: CutCriterion,
    /// Sum of the leaves below each node, by heap index, in units of 1 / [`OPEN`].
    sums: Vec<u32>,
    /// Sum of `x - x²` of the leaves below each node, in units of 1 / `OPEN`²; nonzero only for leaves between 0 and 1.
    /// Empty if there are none.
    between: Vec<u32>,
    /// Whether a node is split, by heap index.
    split: Vec<bool>,
}

impl CutSelector {
    /// A selector for trees of `height`.
    pub fn new(height: u32, criterion: CutCriterion) -> Self {
        let nodes = 2 << height;
        Self { height, criterion, sums: vec![0; nodes], between: Vec::new(), split: vec![false; nodes] }
    }

    /// Appends the packed cut of `leaves` (0 to [`OPEN`], in tree order) to `cut`, which must be empty. Returns the sum of
    /// squared errors of the stored values over all leaves.
    pub fn select(&mut self, leaves: &[u8], cut: &mut Vec<u16>) -> f64 {
        self.select_parts(leaves, &CutPart::ALL, cut)
    }

    /// [`Self::select`] for the stale parts of a cut; only leaves below these count. A bound on the whole cut needs all leaves, see
    /// [`CutCriterion::is_local`].
    pub fn select_parts(&mut self, leaves: &[u8], parts: &[CutPart], cut: &mut Vec<u16>) -> f64 {
        assert_eq!(leaves.len(), 1 << self.height, "one value per leaf");
        self.sum(leaves);
        self.split.fill(false);
        let is_local = self.criterion.is_local(leaves.len());
        if !is_local {
            self.split_worst_first();
        }
        self.emit(is_local, parts, cut)
    }

    fn sum(&mut self, leaves: &[u8]) {
        sum_up(&mut self.sums, leaves.iter().map(|&leaf| u32::from(leaf)));
        self.between.clear();
        if leaves.iter().any(|&leaf| leaf != 0 && leaf != OPEN) {
            self.between.resize(self.sums.len(), 0);
            sum_up(&mut self.between, leaves.iter().map(|&leaf| u32::from(leaf) * u32::from(OPEN - leaf)));
        }
    }

    /// Sums of the leaves below a node and of their squares, in units of 1 / `OPEN` and 1 / `OPEN`².
    fn moments(&self, node: usize) -> (u64, u64) {
        let (sum, between) = (u64::from(self.sums[node]), self.between.get(node).copied().unwrap_or(0));
        (sum, sum * u64::from(OPEN) - u64::from(between))
    }

    fn size(&self, node: usize) -> u32 {
        1 << (self.height - node.ilog2())
    }

    /// `|C| var`: the squared error of a node.
    fn error(&self, node: usize) -> f32 {
        let ((sum, squares), size) = (self.moments(node), u64::from(self.size(node)));
        error_of(size * squares - sum * sum, size)
    }

    fn exceeds_sigma(&self, node: usize) -> bool {
        self.criterion.splits(self.error(node))
    }

    /// Marks nodes for splitting, largest error first, until a bound holds.
    fn split_worst_first(&mut self) {
        let allowed = self.criterion.total_error.map(|e| f64::from(e) * f64::from(e));
        // Errors are not negative, so their bits order like their values; ties go to the left node.
        let entry = |s: &Self, node: usize| (s.error(node).to_bits(), std::cmp::Reverse(node));
        let mut queue = BinaryHeap::from([entry(self, 1)]);
        let mut total = f64::from(self.error(1));
        let mut nodes = 1;
        while let Some((error, std::cmp::Reverse(node))) = queue.pop() {
            let fine = allowed.map_or(!self.exceeds_sigma(node), |allowed| total <= allowed);
            if fine || nodes >= self.criterion.max_nodes || error == 0 {
                break;
            }
            self.split[node] = true;
            nodes += 1;
            total -= f64::from(self.error(node));
            for child in [2 * node, 2 * node + 1] {
                total += f64::from(self.error(child));
                queue.push(entry(self, child));
            }
        }
    }

    /// Writes the nodes left to right.
    fn emit(&self, by_sigma: bool, parts: &[CutPart], cut: &mut Vec<u16>) -> f64 {
        let mut squared_error = 0.0;
        let mut writer = CutWriter::new(self.height, cut);
        let mut stack: Vec<CutPart> = parts.iter().rev().copied().collect();
        while let Some(part) = stack.pop() {
            let node = match part {
                CutPart::Kept(packed) => {
                    writer.push(packed);
                    continue;
                }
                CutPart::Stale(node) => node,
            };
            if self.split[node] || (by_sigma && self.exceeds_sigma(node)) {
                stack.extend([2 * node + 1, 2 * node].map(CutPart::Stale));
                continue;
            }
            let ((sum, squares), size) = (self.moments(node), f64::from(self.size(node)));
            let (sum, squares) = (sum as f64 / UNIT, squares as f64 / (UNIT * UNIT));
            let packed = pack_node(node.ilog2(), (sum / size) as f32);
            let stored = f64::from(value(packed));
            squared_error += squares - 2.0 * sum * stored + size * stored * stored;
            writer.push(packed);
        }
        squared_error
    }
}

/// Fills the leaves of a heap, and all nodes above them with the sums of their children.
fn sum_up(heap: &mut [u32], leaves: impl ExactSizeIterator<Item = u32>) {
    let n = leaves.len();
    heap[n..].iter_mut().zip(leaves).for_each(|(sum, leaf)| *sum = leaf);
    (1..n).rev().for_each(|i| heap[i] = heap[2 * i] + heap[2 * i + 1]);
}

/// Appends nodes left to right and replaces equal siblings by their parent, without loss.
pub(super) struct CutWriter<'a> {
    height: u32,
    cut: &'a mut Vec<u16>,
    end: u32,
}

impl<'a> CutWriter<'a> {
    pub(super) fn new(height: u32, cut: &'a mut Vec<u16>) -> Self {
        assert!(cut.is_empty(), "cuts are written to empty buffers");
        Self { height, cut, end: 0 }
    }

    pub(super) fn push(&mut self, node: u16) {
        self.push_where(node, |_| true);
    }

    /// [`Self::push`] that merges only into parents for which `may_merge` holds.
    pub(super) fn push_where(&mut self, node: u16, may_merge: impl Fn(u16) -> bool) {
        self.cut.push(node);
        self.end += 1 << (self.height - depth(node));
        while let [.., left, right] = self.cut[..] {
            let parent_size = 2_u32 << (self.height - depth(right));
            if left != right || !self.end.is_multiple_of(parent_size) {
                break;
            }
            let parent = (right & VALUE_MAX) | ((depth(right) - 1) as u16) << 12;
            if !may_merge(parent) {
                break;
            }
            self.cut.pop();
            let last = self.cut.len() - 1;
            self.cut[last] = parent;
        }
    }
}

/// Sum over all leaves of the squared differences between a packed cut and `leaves`, each 0 to [`OPEN`].
pub fn squared_error(height: u32, cut: &[u16], leaves: &[u8]) -> f64 {
    let (mut first, mut sum) = (0, 0.0);
    for &node in cut {
        let (size, stored) = (1 << (height - depth(node)), f64::from(value(node)));
        let below = leaves[first..first + size].iter().map(|&leaf| u64::from(leaf));
        let (ones, squares) = below.fold((0, 0), |(sum, squares), leaf| (sum + leaf, squares + leaf * leaf));
        let (ones, squares) = (ones as f64 / UNIT, squares as f64 / (UNIT * UNIT));
        sum += squares - 2.0 * ones * stored + size as f64 * stored * stored;
        first += size;
    }
    sum
}

/// Coarsens a packed cut: keeps only splits whose node has `|C| var > sigma²` by the stored means.
///
/// A child's error never exceeds its parent's. So one `sigma` for all vertices gives the same cuts as a greedy priority
/// queue over all of them.
pub fn prune(height: u32, sigma: f32, cut: &[u16]) -> Vec<u16> {
    let mut pruned: Vec<u16> = Vec::with_capacity(cut.len());
    let mut end = 0_u32;
    for &node in cut {
        pruned.push(node);
        end += 1 << (height - depth(node));
        while let [.., left, right] = pruned[..] {
            let child_size = 1_u32 << (height - depth(right));
            let siblings = depth(left) == depth(right) && end.is_multiple_of(2 * child_size);
            let mean = 0.5 * (value(left) + value(right));
            if !siblings || 2.0 * child_size as f32 * (mean - mean * mean) > sigma * sigma {
                break;
            }
            pruned.pop();
            let last = pruned.len() - 1;
            pruned[last] = pack_node(depth(right) - 1, mean);
        }
    }
    pruned
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::packed::cut_len;

    fn leaves(height: u32, seed: u64) -> Vec<u8> {
        // Runs of random lengths: visibility is coherent in tree order.
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut v = Vec::new();
        let mut bit = 0;
        while v.len() < 1 << height {
            v.extend(std::iter::repeat_n(bit, rng.usize(1..60)));
            bit = OPEN - bit;
        }
        v.truncate(1 << height);
        v
    }

    fn share(leaf: u8) -> f64 {
        f64::from(leaf) / 255.0
    }

    fn expand(height: u32, cut: &[u16]) -> Vec<f32> {
        cut.iter().flat_map(|&n| std::iter::repeat_n(value(n), 1 << (height - depth(n)))).collect()
    }

    fn select(height: u32, criterion: CutCriterion, leaves: &[u8]) -> (Vec<u16>, f64) {
        let mut cut = Vec::new();
        let error = CutSelector::new(height, criterion).select(leaves, &mut cut);
        assert_eq!(cut_len(height, &cut), Ok(cut.len()));
        (cut, error)
    }

    #[test]
    fn nodes_split_from_the_least_error_in_whole_numbers_on() {
        for (sigma, size) in [(2.0, 1024_u32), (0.25, 2048), (0.3, 2), (1.0, 64), (0.0, 8)] {
            let criterion = CutCriterion { sigma, ..CutCriterion::default() };
            let least = criterion.least_split(size);
            let splits = |error: u64| criterion.splits(error_of(error, size.into()));
            assert!(splits(least) && (least == 0 || !splits(least - 1)), "{sigma} and {size}");
            let by_hand = f64::from(sigma).powi(2) * f64::from(size) * UNIT * UNIT;
            assert!((least as f64 - by_hand).abs() <= 1.0 + 1e-7 * by_hand, "{least} and {by_hand}");
        }
        let never = CutCriterion { sigma: 1e9, ..CutCriterion::default() }.least_split(64);
        assert!(never > (64 * 255_u64).pow(2) / 4, "more than any node has");
    }

    fn squared_error_leaf_by_leaf(height: u32, cut: &[u16], leaves: &[u8]) -> f64 {
        let differences = expand(height, cut).into_iter().zip(leaves).map(|(a, &b)| f64::from(a) - share(b));
        differences.map(|d| d * d).sum()
    }

    #[test]
    fn every_node_keeps_the_bound_and_its_parent_breaks_it() {
        let (height, sigma) = (10, 1.5);
        for seed in 0..20 {
            let leaves = leaves(height, seed);
            let (cut, error) = select(height, CutCriterion { sigma, ..Default::default() }, &leaves);
            assert!((error - squared_error_leaf_by_leaf(height, &cut, &leaves)).abs() < 1e-2);
            assert!((error - squared_error(height, &cut, &leaves)).abs() < 1e-9);
            let mean = |first: usize, size: usize| {
                leaves[first..first + size].iter().map(|&x| share(x)).sum::<f64>() / size as f64
            };
            let variance = |first, size: usize| size as f64 * (mean(first, size) - mean(first, size).powi(2));
            // A node keeps the bound, or stands for two equal siblings that do.
            fn bounded(
                first: usize,
                size: usize,
                bound: f64,
                v: &dyn Fn(usize, usize) -> f64,
                m: &dyn Fn(usize, usize) -> f64,
            ) -> bool {
                let half = size / 2;
                v(first, size) <= bound + 1e-4
                    || (m(first, half) == m(first + half, half)
                        && bounded(first, half, bound, v, m)
                        && bounded(first + half, half, bound, v, m))
            }
            let mut first = 0;
            for &node in &cut {
                let size = 1 << (height - depth(node));
                assert!(bounded(first, size, f64::from(sigma * sigma), &variance, &mean));
                if depth(node) > 0 {
                    assert!(variance(first - first % (2 * size), 2 * size) > f64::from(sigma * sigma) - 1e-4);
                }
                first += size;
            }
        }
    }

    #[test]
    fn light_that_passes_in_part_is_kept_and_errors_are_those_of_its_share() {
        let (height, sigma) = (10, 1.5);
        let binary = leaves(height, 11);
        // A pane covers the second half: visible leaves become 77 of 255.
        let dimmed = |(i, &leaf): (usize, &u8)| if i >= 512 { leaf / 255 * 77 } else { leaf };
        let leaves: Vec<u8> = binary.iter().enumerate().map(dimmed).collect();
        for criterion in [
            CutCriterion { sigma, ..Default::default() },
            CutCriterion { sigma: 0.0, max_nodes: 64, total_error: None },
            CutCriterion { sigma: 0.0, max_nodes: u32::MAX, total_error: Some(3.0) },
        ] {
            let (cut, error) = select(height, criterion, &leaves);
            assert!((error - squared_error_leaf_by_leaf(height, &cut, &leaves)).abs() < 1e-2);
            assert!((error - squared_error(height, &cut, &leaves)).abs() < 1e-9);
            let (of_binary, _) = select(height, criterion, &binary);
            assert!(squared_error(height, &of_binary, &leaves) > 3.0 * error.max(1.0), "negative control");
        }
        // Light that passes evenly has no edge to follow.
        assert_eq!(select(height, CutCriterion { sigma, ..Default::default() }, &[100; 1024]).0.len(), 1);
    }

    #[test]
    fn leaves_that_stand_for_equal_ones_give_the_same_cuts() {
        let coarse = leaves(8, 5);
        let fine: Vec<u8> = coarse.iter().flat_map(|&leaf| [leaf; 16]).collect();
        for criterion in [
            CutCriterion { sigma: 2.5, ..Default::default() },
            CutCriterion { sigma: 2.5, max_nodes: 20, total_error: None },
            CutCriterion { sigma: 0.0, max_nodes: u32::MAX, total_error: Some(6.0) },
        ] {
            let expected = select(12, criterion, &fine).0;
            assert_eq!(select(8, criterion.of_means(16), &coarse).0, expected);
            assert_ne!(select(8, criterion, &coarse).0, expected, "negative control");
        }
    }

    #[test]
    fn sigma_zero_keeps_the_function_exactly() {
        let leaves = leaves(9, 7);
        let (cut, error) = select(9, CutCriterion { sigma: 0.0, ..Default::default() }, &leaves);
        assert_eq!(error, 0.0);
        let exact: Vec<f32> = leaves.iter().map(|&x| share(x) as f32).collect();
        assert_eq!(expand(9, &cut), exact);
        assert!(cut.len() < leaves.len(), "equal siblings merge");
    }

    #[test]
    fn maximum_size_is_kept_by_splitting_the_worst_nodes() {
        let leaves = leaves(10, 3);
        let bound = |max_nodes| CutCriterion { sigma: 0.0, max_nodes, total_error: None };
        let errors: Vec<f64> = [4, 16, 64, 1024]
            .map(|k| {
                let (cut, error) = select(10, bound(k), &leaves);
                assert!(cut.len() <= k as usize);
                error
            })
            .to_vec();
        assert!(errors.windows(2).all(|w| w[0] > w[1]), "{errors:?}");
    }

    #[test]
    fn total_error_mode_stops_at_its_bound_and_not_before() {
        let leaves = leaves(10, 5);
        let criterion = |e| CutCriterion { sigma: 0.0, max_nodes: u32::MAX, total_error: Some(e) };
        let (coarse, error) = select(10, criterion(6.0), &leaves);
        assert!(error <= 36.0 + 0.01);
        let (_, one_node_less) =
            select(10, CutCriterion { max_nodes: coarse.len() as u32 - 4, ..criterion(6.0) }, &leaves);
        assert!(one_node_less > 36.0);
    }

    #[test]
    fn pruning_is_monotone_and_keeps_means() {
        let leaves = leaves(10, 9);
        let (fine, _) = select(10, CutCriterion { sigma: 0.5, ..Default::default() }, &leaves);
        let mut before = fine.len() + 1;
        for sigma in [0.5, 1.0, 2.0, 4.0, 100.0] {
            let cut = prune(10, sigma, &fine);
            assert_eq!(cut_len(10, &cut), Ok(cut.len()));
            assert!(cut.len() < before);
            before = cut.len();
            let mean = |c: &[u16]| expand(10, c).iter().sum::<f32>() / 1024.0;
            assert!((mean(&cut) - mean(&fine)).abs() < 2e-3);
        }
        assert_eq!(before, 1);
    }
}
