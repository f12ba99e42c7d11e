//! Cuts of which some parts are selected anew, because only some leaves have new values.
//!
//! Leaves are renewed by granules, the nodes of one depth: whether a granule is stale depends on no cut. So where values come back,
//! the same nodes come back. A node of a cut above the granules is renewed whole if one of its granules is stale, unless it is
//! uniform: its value is then that of each granule.

use super::packed::{VALUE_MAX, depth};
use std::ops::Range;

/// A part of a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutPart {
    /// A node that stays, packed.
    Kept(u16),
    /// The leaves below a node, by its heap index, to be selected anew.
    Stale(usize),
}

impl CutPart {
    /// The whole tree, to be selected anew.
    pub const ALL: [Self; 1] = [Self::Stale(1)];
}

/// Whether a node of a cut of visibility says what each of its leaves is: all dark or all visible. In a larger node the value of a
/// single leaf may be lost.
pub fn is_uniform_visibility(height: u32, node: u16) -> bool {
    let leaves = 1_u32 << (height - depth(node));
    matches!(node & VALUE_MAX, 0 | VALUE_MAX) && leaves < 2 * u32::from(VALUE_MAX)
}

/// Whether a node of a cut of solid angles says what each of its leaves is: hidden.
pub fn is_uniform_solid_angle(_height: u32, node: u16) -> bool {
    node & VALUE_MAX == 0
}

/// The parts of a cut over a tree of `height`, left to right. `is_stale` has one entry per granule.
pub fn cut_parts(height: u32, cut: &[u16], is_stale: &[bool], is_uniform: fn(u32, u16) -> bool) -> Vec<CutPart> {
    let granules = is_stale.len().ilog2();
    let (mut parts, mut first) = (Vec::new(), 0_usize);
    for &node in cut {
        let depth = depth(node);
        // The node itself, or the granule that contains it.
        let root = (1 << depth.min(granules)) + (first >> (height - depth.min(granules)));
        let below = granules - depth.min(granules);
        let start = (root << below) - is_stale.len();
        let stale = &is_stale[start..start + (1 << below)];
        match stale.contains(&true) {
            false => parts.push(CutPart::Kept(node)),
            true if below > 0 && is_uniform(height, node) => {
                let granule = CutPart::Kept((node & VALUE_MAX) | (granules as u16) << 12);
                parts.extend((root << below..).zip(stale).map(
                    |(root, &stale)| {
                        if stale { CutPart::Stale(root) } else { granule }
                    },
                ));
            }
            true if parts.last() != Some(&CutPart::Stale(root)) => parts.push(CutPart::Stale(root)),
            true => (),
        }
        first += 1 << (height - depth);
    }
    parts
}

/// The leaves below a node of a tree of `height`, by its heap index.
pub fn leaves_below(height: u32, node: usize) -> Range<usize> {
    let below = height - node.ilog2();
    let start = (node << below) - (1 << height);
    start..start + (1 << below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        cut::{CutCriterion, CutSelector, SourceCriterion, SourceCutSelector},
        ray::OPEN,
    };

    const HEIGHT: u32 = 10;

    /// Runs of light and dark, some of them elsewhere in `range`. A run of one leaf could hide in a node without a split.
    fn leaves(seed: u64, range: Range<usize>, other: u64) -> Vec<u8> {
        let runs = |seed| {
            let mut rng = fastrand::Rng::with_seed(seed);
            let mut all = Vec::new();
            while all.len() < 1 << HEIGHT {
                all.extend(std::iter::repeat_n(if rng.bool() { OPEN } else { 0 }, rng.usize(2..90)));
            }
            all
        };
        let (mut all, others) = (runs(seed), runs(other));
        all.truncate(1 << HEIGHT);
        all[range.clone()].copy_from_slice(&others[range]);
        all
    }

    fn stale(range: &Range<usize>) -> Vec<bool> {
        (0..32).map(|granule| granule * 32 < range.end && range.start < (granule + 1) * 32).collect()
    }

    #[test]
    fn a_renewed_cut_is_a_new_one_or_finer_and_values_that_come_back_bring_back_the_cut() {
        // Without a bound each node is uniform, and no leaf hides.
        assert_eq!(come_back(0.0), 50);
        assert!(come_back(1.0) > 40, "a node above the granules may hide a leaf, and stays split then");
    }

    /// How many of 50 cuts come back.
    fn come_back(sigma: f32) -> usize {
        let criterion = CutCriterion { sigma, ..CutCriterion::default() };
        let mut selector = CutSelector::new(HEIGHT, criterion);
        let mut whole = |leaves: &[u8]| {
            let mut cut = Vec::new();
            selector.select(leaves, &mut cut);
            cut
        };
        let (mut longer, mut other, mut same) = (0.0, 0, 0);
        for seed in 0..50 {
            let range = 300 + seed as usize..420 + seed as usize;
            let (before, now) = (leaves(seed, 0..0, 0), leaves(seed, range.clone(), seed + 99));
            let renewed = |old: &[u16], leaves: &[u8], stale: &[bool]| {
                let parts = cut_parts(HEIGHT, old, stale, is_uniform_visibility);
                // Leaves that are not renewed are unknown.
                let mut known = vec![OPEN / 2; 1 << HEIGHT];
                for part in &parts {
                    if let CutPart::Stale(node) = part {
                        let below = leaves_below(HEIGHT, *node);
                        known[below.clone()].copy_from_slice(&leaves[below]);
                    }
                }
                let mut cut = Vec::new();
                CutSelector::new(HEIGHT, criterion).select_parts(&known, &parts, &mut cut);
                cut
            };
            let (old, new) = (whole(&before), whole(&now));
            let there = renewed(&old, &now, &stale(&range));
            assert!(crate::cut::validate_depths(HEIGHT, there.iter().map(|&node| depth(node))).is_ok());
            let error = |cut: &[u16]| crate::cut::squared_error(HEIGHT, cut, &now);
            assert!(error(&there) <= error(&new) + 1e-3, "{} {}", error(&there), error(&new));
            longer += there.len() as f32 / new.len() as f32 / 50.0;
            let back = renewed(&there, &before, &stale(&range));
            let error = |cut: &[u16]| crate::cut::squared_error(HEIGHT, cut, &before);
            assert!(error(&back) <= error(&old) + 1e-3);
            same += usize::from(back == old);
            let forgotten = stale(&(range.start..range.start + 1));
            other += usize::from(renewed(&there, &before, &forgotten) != old);
        }
        assert!(longer < 1.15, "{longer}");
        assert!(other > 25, "negative control: leaves are forgotten in {other} of 50");
        same
    }

    #[test]
    fn of_a_uniform_node_only_stale_granules_are_renewed() {
        let dark = [0_u16];
        let mut is_stale = [false; 32];
        is_stale[5] = true;
        let stale = |parts: Vec<CutPart>| parts.into_iter().filter(|part| matches!(part, CutPart::Stale(_))).collect();
        let of = |cut: &[u16]| -> Vec<CutPart> { stale(cut_parts(HEIGHT, cut, &is_stale, is_uniform_visibility)) };
        assert_eq!(of(&dark), [CutPart::Stale(32 + 5)]);
        assert_eq!(of(&[VALUE_MAX]), [CutPart::Stale(32 + 5)]);
        assert_eq!(of(&[100]), [CutPart::Stale(1)], "negative control: nobody knows its leaves");
        assert!(!is_uniform_visibility(13, 0), "one leaf of 8,192 rounds to none");
        let mut cut = Vec::new();
        let parts = cut_parts(HEIGHT, &dark, &is_stale, is_uniform_visibility);
        CutSelector::new(HEIGHT, CutCriterion::default()).select_parts(&[0; 1 << HEIGHT], &parts, &mut cut);
        assert_eq!(cut, dark, "nothing has changed");
    }

    #[test]
    fn cuts_of_solid_angles_are_renewed_as_those_of_visibility_are() {
        let criterion = SourceCriterion { sigma: 0.5, max_solid_angle: 0.3, contrast: 0.1 };
        let angles = |leaves: Vec<u8>| -> Vec<f32> { leaves.into_iter().map(|v| f32::from(v) * 1e-5).collect() };
        let range = 200..333;
        let (before, now) = (angles(leaves(1, 0..0, 0)), angles(leaves(1, range.clone(), 7)));
        let select = |leaves: &[f32], parts: &[CutPart]| {
            let mut cut = Vec::new();
            SourceCutSelector::new(HEIGHT, criterion).select_parts(leaves, parts, &mut cut);
            cut
        };
        let old = select(&before, &CutPart::ALL);
        let there = select(&now, &cut_parts(HEIGHT, &old, &stale(&range), is_uniform_solid_angle));
        assert!(there != old);
        assert_eq!(select(&before, &cut_parts(HEIGHT, &there, &stale(&range), is_uniform_solid_angle)), old);
        assert!(
            cut_parts(HEIGHT, &old, &[false; 32], is_uniform_solid_angle)
                .iter()
                .all(|part| matches!(part, CutPart::Kept(_)))
        );
    }
}
