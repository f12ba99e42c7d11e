use super::*;
use crate::cut::{
    CutCriterion, CutSelector,
    merge::Cursor,
    packed::{PackedCursor, pack_node},
    validate_depths,
};
use crate::ray::OPEN;

const HEIGHT: u32 = 9;
const LEAVES: usize = 1 << HEIGHT;

/// Luminance of all nodes; leaves differ by orders of magnitude.
fn luminance(seed: u64) -> Vec<f32> {
    let mut rng = fastrand::Rng::with_seed(seed);
    let leaves: Vec<f32> = (0..LEAVES).map(|_| rng.f32().powi(8) * 100.0).collect();
    crate::light_tree::means_up_the_tree(&leaves)
}

/// A stored visibility cut with runs of equal leaves.
fn stored(seed: u64) -> Vec<u16> {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut leaves: Vec<u8> = Vec::new();
    while leaves.len() < LEAVES {
        leaves.extend(std::iter::repeat_n(OPEN * rng.u8(0..2), rng.usize(1..20)));
    }
    leaves.truncate(LEAVES);
    let mut cut = Vec::new();
    CutSelector::new(HEIGHT, CutCriterion { sigma: 0.5, ..Default::default() }).select(&leaves, &mut cut);
    cut
}

/// A cut of solid angles with the same nodes.
fn solid_angle_cut(seed: u64) -> Vec<u16> {
    let code = |node: u16| solid_angle_code(value(node) * 0.02 + 1e-5);
    stored(seed).iter().map(|&node| (node & !VALUE_MAX) | code(node)).collect()
}

fn lit(values: CutValues, luminance: &[f32], tau: f32) -> LitCuts {
    LitCuts::new(values, luminance.iter().copied(), tau)
}

/// First leaf and leaves of each node.
fn places(nodes: impl Iterator<Item = u16>) -> Vec<(usize, usize)> {
    let mut first = 0;
    let place = |node| {
        let size = LEAVES >> depth(node);
        first += size;
        (first - size, size)
    };
    nodes.map(place).collect()
}

/// Checks that a lit cut is valid. Returns the largest share of the whole light that a node moves, and the relative
/// change of the whole light.
fn checked(values: CutValues, luminance: &[f32], nodes: &[u16], lit: &[LitNode]) -> (f32, f32) {
    assert_eq!(validate_depths(HEIGHT, lit.iter().map(|n| depth(n.packed()))), Ok(lit.len()));
    let stored = places(nodes.iter().copied());
    let light = |(first, size): (usize, usize)| luminance[(LEAVES + first) / size] * size as f32;
    let whole: f32 = stored.iter().zip(nodes).map(|(&place, &node)| light(place) * values.of(node)).sum();
    let (mut largest, mut sum) = (0.0_f32, 0.0);
    for (node, (first, size)) in lit.iter().zip(places(lit.iter().map(|n| n.packed()))) {
        assert_eq!(stored[node.stored()].0, first, "a lit node knows where its stored ones begin");
        let below = || stored.iter().zip(nodes).skip(node.stored()).take_while(|((f, _), _)| *f < first + size);
        let mean = values.of(node.packed());
        let moved: f32 = below().map(|(&place, &node)| light(place) * (values.of(node) - mean).abs()).sum();
        largest = largest.max(moved / whole);
        sum += below().map(|(&place, _)| light(place) * mean).sum::<f32>();
    }
    (largest, (sum / whole - 1.0).abs())
}

#[test]
fn no_node_moves_more_than_tau_and_the_light_stays() {
    for values in [CutValues::Visibility, CutValues::SolidAngles] {
        for seed in 0..8 {
            let luminance = luminance(seed);
            let nodes = if values == CutValues::Visibility { stored(seed) } else { solid_angle_cut(seed) };
            let mut lengths = Vec::new();
            for tau in [0.001, 0.003, 0.01, 0.1] {
                let cut = lit(values, &luminance, tau).cut(&nodes);
                let (moved, change) = checked(values, &luminance, &nodes, &cut);
                // Solid-angle codes are accurate to half a percent, visibility codes to an eight-thousandth.
                assert!(moved < tau + 3e-3 && change < 3e-3, "{values:?} {tau}: {moved} {change}");
                lengths.push(cut.len());
            }
            assert!(lengths.is_sorted_by(|a, b| a >= b) && lengths[0] < nodes.len(), "{lengths:?} of {}", nodes.len());
            let coarse = lit(values, &luminance, 0.1).cut(&nodes);
            let moved = checked(values, &luminance, &nodes, &coarse).0;
            assert!(moved > 0.01, "negative control: a coarse cut moves more than a finer one may");
        }
    }
}

#[test]
fn a_tau_of_zero_leaves_the_stored_cut_bit_for_bit() {
    let nodes = stored(3);
    for luminance in [luminance(1), vec![0.0; 2 * LEAVES], vec![1.0; 2 * LEAVES]] {
        let cut = lit(CutValues::Visibility, &luminance, 0.0).cut(&nodes);
        assert!(cut.iter().map(|n| n.packed()).eq(nodes.iter().copied()));
        assert!(cut.iter().enumerate().all(|(i, n)| n.stored() == i));
    }
    let coarser = lit(CutValues::Visibility, &luminance(1), 0.003).cut(&nodes);
    assert!(coarser.len() < nodes.len(), "negative control");
}

#[test]
fn any_light_gives_valid_cuts_of_finite_values() {
    let spot = |l: f32| {
        let mut leaves = vec![0.0; LEAVES];
        leaves[77] = l;
        crate::light_tree::means_up_the_tree(&leaves)
    };
    let even = |l: f32| vec![l; 2 * LEAVES];
    let nothing_seen = [pack_node(0, 0.0)];
    for luminance in [even(0.0), even(1e30), even(1e-30), spot(1e30), spot(1e-30), spot(1.0)] {
        for tau in [0.0, 1e-3, 1.0] {
            for values in [CutValues::Visibility, CutValues::SolidAngles] {
                for nodes in [&stored(5)[..], &nothing_seen] {
                    let cut = lit(values, &luminance, tau).cut(nodes);
                    assert_eq!(validate_depths(HEIGHT, cut.iter().map(|n| depth(n.packed()))), Ok(cut.len()));
                    assert!(cut.len() <= nodes.len());
                }
            }
        }
    }
    let dark = lit(CutValues::Visibility, &even(0.0), 1e-3).cut(&stored(5));
    assert_eq!(dark.len(), 1, "where no light is, no node is needed");
}

#[test]
fn cuts_of_vertices_are_made_once_and_cursors_pass_their_nodes() {
    let mut packed = PackedCuts::default();
    for seed in 0..3 {
        let offset = packed.push_cut(&stored(seed));
        packed.push_vertex(offset);
    }
    let cuts = lit(CutValues::Visibility, &luminance(9), 0.01);
    let of_two = cuts.of(&packed, 2).as_ptr();
    cuts.make_all(&packed);
    assert_eq!(cuts.of(&packed, 2).as_ptr(), of_two);
    assert_eq!(*cuts.of(&packed, 1), *cuts.cut(&stored(1)));
    let nodes = cuts.of(&packed, 1);
    let mut cursor = PackedCursor::new(HEIGHT, nodes);
    let mut ends = vec![cursor.end()];
    while cursor.end() < LEAVES as u32 {
        cursor.advance();
        ends.push(cursor.end());
    }
    assert!(ends.iter().map(|&e| e as usize).eq(places(nodes.iter().map(|n| n.packed())).iter().map(|(f, s)| f + s)));
    assert_eq!(cuts.clone().with_tau(0.0).of(&packed, 1).len(), stored(1).len(), "another tau, other cuts");
}
