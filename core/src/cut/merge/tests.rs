//! Properties of merging, against brute force and against the paper's own loop.

mod full_precision;

use super::*;
use full_precision::{Cut, CutNode, combine, product_integral, visit_values};
use proptest::prelude::*;

/// A random cut: random decisions split nodes, random integers give the values.
fn cut(height: u32) -> impl Strategy<Value = Cut> {
    let decisions = prop::collection::vec(any::<u8>(), 1 << (height + 1));
    let values = prop::collection::vec(0_u8..=16, 1 << height);
    (decisions, values, 40_u8..220).prop_map(move |(decisions, values, odds)| {
        let mut nodes = Vec::new();
        let mut stack = vec![(1_usize, 0_u8)];
        while let Some((heap, depth)) = stack.pop() {
            if u32::from(depth) < height && decisions[heap] < odds {
                stack.push((2 * heap + 1, depth + 1));
                stack.push((2 * heap, depth + 1));
            } else {
                nodes.push(CutNode { depth, value: f32::from(values[nodes.len()]) / 16.0 });
            }
        }
        Cut::new(height, nodes).unwrap()
    })
}

fn cuts() -> impl Strategy<Value = Vec<Cut>> {
    (1_u32..=8).prop_flat_map(|height| prop::collection::vec(cut(height), 1..=5))
}

fn references(cuts: &[Cut]) -> Vec<&Cut> {
    cuts.iter().collect()
}

/// A node as the paper stores it.
#[derive(Clone, Copy)]
struct PaperNode {
    index: u32,
    leftleaf: u32,
    size: u32,
    value: f32,
}

/// Postorder index and leftleaf of a cut's nodes: `leftleaf = 2a - popcount(a)`, `index = leftleaf + 2^(h+1) - 2`.
fn paper_nodes(cut: &Cut) -> Vec<PaperNode> {
    let mut first = 0_u32;
    let node = |n: &CutNode| {
        let h = cut.height() - u32::from(n.depth);
        let leftleaf = 2 * first - first.count_ones();
        first += 1 << h;
        PaperNode { index: leftleaf + (2 << h) - 2, leftleaf, size: 1 << h, value: n.value }
    };
    cut.nodes().iter().map(node).collect()
}

/// The paper's loop (3.2): the terms of the multi-product in the order in which it forms them.
fn paper_terms(cuts: &[Cut]) -> Vec<(u32, Vec<f32>)> {
    let lists: Vec<Vec<PaperNode>> = cuts.iter().map(paper_nodes).collect();
    let mut at = vec![0; lists.len()];
    let mut terms = Vec::new();
    loop {
        let current: Vec<PaperNode> = lists.iter().zip(&at).map(|(l, &i)| l[i]).collect();
        let min_index = current.iter().map(|n| n.index).min().unwrap();
        let max_leftleaf = current.iter().map(|n| n.leftleaf).max().unwrap();
        if max_leftleaf <= min_index {
            let size = current.iter().map(|n| n.size).min().unwrap();
            terms.push((size, current.iter().map(|n| n.value).collect()));
        }
        for (j, node) in current.iter().enumerate() {
            if node.index == min_index {
                at[j] += 1;
                if at[j] == lists[j].len() {
                    return terms;
                }
            }
        }
    }
}

fn interval_terms(cuts: &[Cut]) -> Vec<(u32, Vec<f32>)> {
    let refs = references(cuts);
    let mut values = vec![0.0; cuts.len()];
    let mut terms = Vec::new();
    visit_values(&refs, &mut values, |interval, values| terms.push((interval.size(), values.to_vec())));
    terms
}

proptest! {
    #[test]
    fn same_terms_in_the_same_order_as_the_papers_loop(cuts in cuts()) {
        prop_assert_eq!(interval_terms(&cuts), paper_terms(&cuts));
    }

    #[test]
    fn merged_nodes_partition_the_leaves_left_to_right(cuts in cuts()) {
        let leaves = 1 << cuts[0].height();
        let mut cursors: Vec<_> = cuts.iter().map(Cut::cursor).collect();
        let mut next = 0;
        merge(leaves, &mut cursors, |interval, _| {
            assert_eq!(interval.first, next);
            assert!(interval.size().is_power_of_two() && interval.first % interval.size() == 0);
            next = interval.end;
        });
        prop_assert_eq!(next, leaves);
    }

    #[test]
    fn merged_size_is_at_least_the_largest_and_at_most_the_sum(cuts in cuts()) {
        let merged = combine(&references(&cuts), |v| v[0]).nodes().len();
        let sizes: Vec<usize> = cuts.iter().map(|c| c.nodes().len()).collect();
        prop_assert!(merged >= *sizes.iter().max().unwrap());
        prop_assert!(merged <= sizes.iter().sum::<usize>());
    }

    #[test]
    fn merging_one_more_cut_only_refines(cuts in cuts()) {
        let all = combine(&references(&cuts), |v| v[0]);
        let fewer = combine(&references(&cuts[..1]), |v| v[0]);
        prop_assert_eq!(all.expand(), fewer.expand());
        prop_assert!(all.nodes().len() >= fewer.nodes().len());
    }

    #[test]
    fn products_sums_and_interpolation_equal_brute_force(cuts in cuts()) {
        let expanded: Vec<Vec<f32>> = cuts.iter().map(Cut::expand).collect();
        let leaf = |i: usize, f: &dyn Fn(&[f32]) -> f32| f(&expanded.iter().map(|e| e[i]).collect::<Vec<_>>());
        let weights = [0.2, 0.5, 0.3, 0.25, 0.125];
        type Operation<'a> = &'a dyn Fn(&[f32]) -> f32;
        let operations: [Operation; 3] = [
            &|v| v.iter().product(),
            &|v| v.iter().sum(),
            &|v| v.iter().zip(weights).map(|(x, w)| x * w).sum(),
        ];
        for f in operations {
            let merged = combine(&references(&cuts), f).expand();
            let brute: Vec<f32> = (0..merged.len()).map(|i| leaf(i, f)).collect();
            prop_assert_eq!(merged, brute);
        }
        let integral = product_integral(&references(&cuts));
        let brute: f64 = (0..expanded[0].len())
            .map(|i| expanded.iter().map(|e| f64::from(e[i])).product::<f64>())
            .sum();
        prop_assert!((integral - brute).abs() <= 1e-9 * brute.max(1.0));
    }

    #[test]
    fn a_dropped_node_and_a_changed_value_are_noticed(cuts in cuts()) {
        // Negative controls of the comparisons above.
        let mut terms = interval_terms(&cuts);
        let truth = paper_terms(&cuts);
        terms[0].1[0] = terms[0].1[0] * 1.01 + 1e-3;
        let differing: Vec<_> = (0..truth.len()).filter(|&i| terms[i] != truth[i]).collect();
        prop_assert_eq!((terms.len(), differing), (truth.len(), vec![0]));
        let dropped = cuts[0].nodes()[1..].to_vec();
        prop_assert!(Cut::new(cuts[0].height(), dropped).is_err());
    }
}

/// Swapping two unequal nodes of one cut changes the product.
#[test]
fn swapped_nodes_are_noticed() {
    let a = Cut::full(&[1.0, 2.0, 3.0, 4.0]);
    let b = Cut::full(&[1.0, 0.0, 0.0, 0.0]);
    let swapped = Cut::full(&[2.0, 1.0, 3.0, 4.0]);
    assert_eq!(product_integral(&[&a, &b]), 1.0);
    assert_eq!(product_integral(&[&swapped, &b]), 2.0);
}

/// The cut of a function by Eq. 5, top down.
fn select(values: &[f32], sigma: f64) -> Cut {
    let height = values.len().ilog2();
    let mut nodes = Vec::new();
    let mut stack = vec![(0_usize, values.len(), 0_u8)];
    while let Some((first, size, depth)) = stack.pop() {
        let leaves = &values[first..first + size];
        if variance_sum(leaves) > sigma * sigma {
            stack.push((first + size / 2, size / 2, depth + 1));
            stack.push((first, size / 2, depth + 1));
        } else {
            nodes.push(CutNode { depth, value: mean(leaves) as f32 });
        }
    }
    Cut::new(height, nodes).unwrap()
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
}

/// `|C| var` of a cluster.
fn variance_sum(values: &[f32]) -> f64 {
    let mean = mean(values);
    values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum()
}

/// `|Σ a b - |C| <a> <b>||` for every cluster of the merged cut.
fn double_product_errors(a: &[f32], b: &[f32], cuts: [&Cut; 2]) -> Vec<f64> {
    let mut cursors = cuts.map(Cut::cursor);
    let mut errors = Vec::new();
    merge(a.len() as u32, &mut cursors, |interval, _| {
        let range = interval.first as usize..interval.end as usize;
        let (a, b) = (&a[range.clone()], &b[range]);
        let exact: f64 = a.iter().zip(b).map(|(&x, &y)| f64::from(x) * f64::from(y)).sum();
        errors.push((exact - a.len() as f64 * mean(a) * mean(b)).abs());
    });
    errors
}

proptest! {
    /// Paper, 3.3, Eq. 8.
    #[test]
    fn double_product_error_is_within_sigma_a_sigma_b_per_cluster(
        a in prop::collection::vec(0.0_f32..4.0, 256),
        b in prop::collection::vec(0.0_f32..1.0, 256),
        sigma_a in 0.5_f64..4.0,
        sigma_b in 0.1_f64..2.0,
    ) {
        let cuts = [&select(&a, sigma_a), &select(&b, sigma_b)];
        for error in double_product_errors(&a, &b, cuts) {
            prop_assert!(error <= sigma_a * sigma_b + 1e-4, "{} > {} {}", error, sigma_a, sigma_b);
        }
    }
}

#[test]
fn cuts_coarser_than_their_sigma_break_the_bound() {
    // Negative control of the bound: two correlated functions as one cluster.
    let step: Vec<f32> = (0..256).map(|i| if i < 128 { 0.0 } else { 1.0 }).collect();
    let root = Cut::new(8, vec![CutNode { depth: 0, value: 0.5 }]).unwrap();
    let errors = double_product_errors(&step, &step, [&root, &root]);
    assert!(errors[0] > 1.0, "{errors:?}");
    let fine = select(&step, 1.0);
    assert!(double_product_errors(&step, &step, [&fine, &fine]).iter().all(|&e| e <= 1.0));
}
