//! Selection of cuts of solid angles over the tree of surface sources (paper, 3.2 and 3.3).
//!
//! Eq. 5 holds for real values as for binary ones. Solid angles are measured in units of 2π/N, the solid angle of each
//! of N sources that together fill the hemisphere, so `sigma` means the same for any N. The second bound is the paper's
//! "maximum solid angle constraint": a node is shaded as one direction, so it must be small, however uniform it is. The
//! third bound is relative. Close to surfaces even a smooth gradient spans many units and would be split down to the
//! leaves, so a node stays whole if its values differ little in proportion to their mean.

mod code;
mod prune;
#[cfg(test)]
mod test_cuts;

pub use code::{LARGEST_SOLID_ANGLE, solid_angle, solid_angle_code, solid_angles};
pub use prune::prune_sources;

use super::{
    packed::{VALUE_MAX, depth},
    renewal::CutPart,
    visibility::CutWriter,
};
use serde::{Deserialize, Serialize};

/// When a node of a source cut is fine enough.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceCriterion {
    /// Split while `|C| var > sigma²` of solid angles in units of 2π/N (Eq. 5).
    pub sigma: f32,
    /// Split nodes of larger solid angle, in steradians.
    pub max_solid_angle: f32,
    /// A node of smaller solid angle stays whole while its standard deviation is at most this multiple of its mean. At
    /// 0.25 up to 6 % of it may be hidden.
    #[serde(default)]
    pub contrast: f32,
}

impl Default for SourceCriterion {
    /// Chosen by comparison with path-traced pictures, see `docs/decisions/0006-three-bounds-of-source-cuts.md`.
    fn default() -> Self {
        Self { sigma: 2.0, max_solid_angle: 0.1, contrast: 0.25 }
    }
}

impl SourceCriterion {
    /// Multiplies the allowed deviations by `factor`; the largest solid angle stays.
    pub fn coarser(self, factor: f32) -> Self {
        // A sigma of zero could not grow.
        Self { sigma: factor * self.sigma.max(0.25), contrast: factor * self.contrast, ..self }
    }

    /// Whether a node of `size` leaves must be split. `sum` and the squared `error` of the mean are in units of 2π/N;
    /// one unit is `unit` steradians.
    pub(super) fn splits(&self, size: f32, sum: f32, error: f32, unit: f32) -> bool {
        let Self { sigma, max_solid_angle, contrast } = *self;
        let is_uneven = error > sigma * sigma && error * size > (contrast * sum) * (contrast * sum);
        is_uneven || sum * unit > max_solid_angle
    }
}

/// Selects cuts of solid angles of `2^height` sources; keeps its buffers between vertices.
pub struct SourceCutSelector {
    height: u32,
    criterion: SourceCriterion,
    /// Sums of the values and of their squares below each node, by heap index, in units of 2π/N.
    sums: Vec<[f32; 2]>,
}

impl SourceCutSelector {
    /// A selector for trees of `height`.
    pub fn new(height: u32, criterion: SourceCriterion) -> Self {
        Self { height, criterion, sums: vec![[0.0; 2]; 2 << height] }
    }

    /// Appends the packed cut of `leaves` (steradians, in tree order) to `cut`, which must be empty. Values are coded
    /// by [`solid_angle_code`].
    pub fn select(&mut self, leaves: &[f32], cut: &mut Vec<u16>) {
        self.select_parts(leaves, &CutPart::ALL, cut);
    }

    /// [`Self::select`] for the stale parts of a cut; only leaves below these count.
    pub fn select_parts(&mut self, leaves: &[f32], parts: &[CutPart], cut: &mut Vec<u16>) {
        assert_eq!(leaves.len(), 1 << self.height, "one value per leaf");
        self.sum_up(leaves);
        let largest = self.criterion.max_solid_angle;
        let mut writer = CutWriter::new(self.height, cut);
        let mut stack: Vec<CutPart> = parts.iter().rev().copied().collect();
        while let Some(part) = stack.pop() {
            let packed = match part {
                CutPart::Kept(packed) => packed,
                CutPart::Stale(node) if self.is_coarse(node) => {
                    stack.extend([2 * node + 1, 2 * node].map(CutPart::Stale));
                    continue;
                }
                CutPart::Stale(node) => {
                    let sum = f64::from(self.sums[node][0]) * f64::from(self.unit());
                    solid_angle_code(sum as f32 / self.size(node)) | (node.ilog2() as u16) << 12
                }
            };
            let solid_angle_of = |node: u16| {
                let leaves = (1_u32 << (self.height - depth(node))) as f32;
                leaves * solid_angle(node & VALUE_MAX)
            };
            writer.push_where(packed, |parent| solid_angle_of(parent) <= largest);
        }
    }

    /// Solid angle in steradians of a value of one.
    fn unit(&self) -> f32 {
        LARGEST_SOLID_ANGLE / (1_u32 << self.height) as f32
    }

    fn sum_up(&mut self, leaves: &[f32]) {
        let (n, per_unit) = (leaves.len(), 1.0 / self.unit());
        for (sums, &leaf) in self.sums[n..].iter_mut().zip(leaves) {
            let value = leaf * per_unit;
            *sums = [value, value * value];
        }
        for i in (1..n).rev() {
            let ([a, b], [c, d]) = (self.sums[2 * i], self.sums[2 * i + 1]);
            self.sums[i] = [a + c, b + d];
        }
    }

    fn size(&self, node: usize) -> f32 {
        (1_u32 << (self.height - node.ilog2())) as f32
    }

    fn is_coarse(&self, node: usize) -> bool {
        if node >= 1 << self.height {
            return false;
        }
        let ([sum, squares], size) = (self.sums[node], self.size(node));
        self.criterion.splits(size, sum, squares - sum * sum / size, self.unit())
    }
}

/// `||stored - leaves||²` of a packed cut over a tree of `height`, in steradians squared.
pub fn solid_angle_error(height: u32, cut: &[u16], leaves: &[f32]) -> f64 {
    let (mut first, mut sum) = (0, 0.0);
    for &node in cut {
        let (size, stored) = (1 << (height - depth(node)), solid_angle(node & VALUE_MAX));
        sum += leaves[first..first + size].iter().map(|&leaf| f64::from(leaf - stored).powi(2)).sum::<f64>();
        first += size;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{test_cuts::*, *};

    #[test]
    fn nodes_keep_both_bounds_and_the_error_is_that_of_the_stored_values() {
        let criterion = SourceCriterion { sigma: 1.0, max_solid_angle: 0.2, contrast: 0.0 };
        for seed in 0..10 {
            let leaves = leaves(seed);
            let cut = select(criterion, &leaves);
            let stored = expand(&cut);
            let exact: f64 = stored.iter().zip(&leaves).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            let error = solid_angle_error(HEIGHT, &cut, &leaves);
            assert!((error - exact).abs() < 1e-6 * exact, "{error} for {exact}");
            let others = solid_angle_error(HEIGHT, &cut, &test_cuts::leaves(seed + 10));
            assert!(others > 2.0 * error, "negative control: {others} for other leaves");
            let mut first = 0;
            for &node in &cut {
                let size = 1 << (HEIGHT - depth(node));
                let values = &leaves[first..first + size];
                let sum: f32 = values.iter().sum();
                assert!(size == 1 || sum <= 0.2 * 1.005, "{sum} sr in one node");
                first += size;
            }
            let total = |v: &[f32]| v.iter().sum::<f32>();
            assert!((total(&stored) / total(&leaves) - 1.0).abs() < 5e-3);
        }
    }

    #[test]
    fn larger_bounds_give_shorter_cuts() {
        let leaves = leaves(3);
        let length =
            |sigma, max_solid_angle| select(SourceCriterion { sigma, max_solid_angle, contrast: 0.0 }, &leaves).len();
        assert!(length(0.5, 9.0) > length(1.0, 9.0) && length(1.0, 9.0) > length(4.0, 9.0));
        assert!(length(4.0, 0.05) > length(4.0, 0.2));
        assert_eq!(length(1e6, 9.0), 1);
    }

    #[test]
    fn equal_leaves_merge_up_to_the_largest_solid_angle_and_hidden_ones_wholly() {
        let even = vec![LARGEST_SOLID_ANGLE / 1024.0; 1024];
        let criterion = SourceCriterion { sigma: 0.0, max_solid_angle: 0.11, contrast: 0.0 };
        assert_eq!(select(criterion, &even).len(), 64, "64 nodes of 0.098 sr");
        assert_eq!(select(criterion, &vec![0.0; 1024]), vec![0]);
    }

    #[test]
    fn slopes_stay_whole_and_edges_are_split() {
        let unit = LARGEST_SOLID_ANGLE / 1024.0;
        let cut = |leaf: fn(usize) -> f32, contrast| {
            let leaves: Vec<f32> = (0..1024).map(|i| 0.2 * unit * leaf(i)).collect();
            select(SourceCriterion { sigma: 0.2, max_solid_angle: 9.0, contrast }, &leaves).len()
        };
        let slope = |i| 1.0 + i as f32 / 1024.0;
        assert_eq!((cut(slope, 0.25), cut(slope, 0.0)), (1, 8));
        let edge = |i| if i < 300 { 0.0 } else { 1.0 };
        assert_eq!(cut(edge, 0.25), cut(edge, 0.0), "what is hidden differs from what is seen by more");
        let sliver = |i| if i < 60 { 0.0 } else { 1.0 };
        assert_eq!((cut(sliver, 0.25), cut(sliver, 0.25 * 0.98) > 1), (1, true), "6 % may be hidden");
    }
}
