//! Leaves and cuts for the tests of selection and pruning.

use super::*;
use crate::cut::packed::cut_len;

/// Height of the tree over the leaves.
pub const HEIGHT: u32 = 10;

/// Runs of similar solid angles, some hidden, some large.
pub fn leaves(seed: u64) -> Vec<f32> {
    let mut rng = fastrand::Rng::with_seed(seed);
    let unit = LARGEST_SOLID_ANGLE / 1024.0;
    let mut values = Vec::new();
    while values.len() < 1024 {
        let level = if rng.bool() { 0.0 } else { unit * 4.0 * rng.f32() };
        values.extend((0..rng.usize(1..60)).map(|i| level * (1.0 + 0.01 * i as f32)));
    }
    values.truncate(1024);
    values
}

/// The cut of leaves.
pub fn select(criterion: SourceCriterion, leaves: &[f32]) -> Vec<u16> {
    let mut cut = Vec::new();
    SourceCutSelector::new(HEIGHT, criterion).select(leaves, &mut cut);
    assert_eq!(cut_len(HEIGHT, &cut), Ok(cut.len()));
    cut
}

/// The stored value of each leaf.
pub fn expand(cut: &[u16]) -> Vec<f32> {
    let repeat = |&n: &u16| std::iter::repeat_n(solid_angle(n & VALUE_MAX), 1 << (HEIGHT - depth(n)));
    cut.iter().flat_map(repeat).collect()
}
