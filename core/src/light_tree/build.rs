//! Top-down clustering into a complete binary tree (paper, 3.4; Hašan et al. 2006).
//!
//! Each node splits its samples at the median of `d(s, c1) - d(s, c2)`, the difference of the distances to two cluster
//! centers. The centers are then recomputed a few times. All metrics are Euclidean in feature space, so this difference
//! is linear in the features: one dot product per sample, and a selection instead of a sort.

use super::Features;
use rayon::join;

/// Recomputations of the two centers ("a few times" in Hašan et al. 2006).
const ITERATIONS: usize = 6;

/// Nodes below this many samples are split on the calling thread.
const SEQUENTIAL: usize = 512;

/// Sample indices in leaf order of a balanced binary clustering; neighbors in order have similar features.
pub fn cluster_order(features: &Features) -> Vec<u32> {
    cluster_order_of_groups(features, 1)
}

/// [`cluster_order`] in groups of `group` samples, which are not split further. The number of samples is a multiple of
/// `group`. A balanced tree over the groups has the same splits.
pub fn cluster_order_of_groups(features: &Features, group: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..features.len() as u32).collect();
    split(&mut order, features, group);
    order
}

fn split(order: &mut [u32], features: &Features, group: usize) {
    if order.len() <= group {
        return;
    }
    let middle = order.len() / group / 2 * group;
    halve(order, middle, features);
    let sequential = order.len() <= SEQUENTIAL;
    let (left, right) = order.split_at_mut(middle);
    if sequential {
        split(left, features, group);
        split(right, features, group);
    } else {
        join(|| split(left, features, group), || split(right, features, group));
    }
}

/// Balanced two-means: afterwards `order` up to `middle` is one cluster, the rest the other.
fn halve(order: &mut [u32], middle: usize, features: &Features) {
    let mut axis = principal_axis(order, features);
    for _ in 0..ITERATIONS {
        partition_along(order, middle, features, &axis);
        axis = difference_of_means(order, middle, features);
    }
    partition_along(order, middle, features, &axis);
}

/// Puts the `middle` samples with the smaller projection on `axis` first; ties go by sample index.
fn partition_along(order: &mut [u32], middle: usize, features: &Features, axis: &[f32]) {
    let mut keyed: Vec<(f32, u32)> = order.iter().map(|&s| (dot(features.row(s), axis), s)).collect();
    keyed.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (slot, (_, sample)) in order.iter_mut().zip(keyed) {
        *slot = sample;
    }
}

/// `c2 - c1`, where the clusters are the two parts of `order`.
fn difference_of_means(order: &[u32], middle: usize, features: &Features) -> Vec<f32> {
    let (first, second) = order.split_at(middle);
    let (first, second) = (mean(first, features), mean(second, features));
    second.iter().zip(&first).map(|(b, a)| b - a).collect()
}

fn mean(samples: &[u32], features: &Features) -> Vec<f32> {
    let mut sum = vec![0.0_f32; features.dimensions()];
    for &s in samples {
        for (total, x) in sum.iter_mut().zip(features.row(s)) {
            *total += x;
        }
    }
    sum.iter().map(|x| x / samples.len() as f32).collect()
}

/// The direction of greatest variance, by power iteration. Two-means seldom gets stuck from this start.
fn principal_axis(order: &[u32], features: &Features) -> Vec<f32> {
    const POWER_ITERATIONS: usize = 6;
    let center = mean(order, features);
    // Start from the sample farthest from the mean, which has a component along the axis.
    let mut axis = order
        .iter()
        .map(|&s| difference(features.row(s), &center))
        .max_by(|a, b| dot(a, a).total_cmp(&dot(b, b)))
        .unwrap_or_else(|| center.clone());
    for _ in 0..POWER_ITERATIONS {
        let length = dot(&axis, &axis).sqrt();
        if !(length > 0.0) {
            break;
        }
        axis.iter_mut().for_each(|x| *x /= length);
        let offset = dot(&center, &axis);
        let mut next = vec![0.0_f32; axis.len()];
        for &s in order {
            let row = features.row(s);
            let weight = dot(row, &axis) - offset;
            for ((n, x), c) in next.iter_mut().zip(row).zip(&center) {
                *n += weight * (x - c);
            }
        }
        axis = next;
    }
    axis
}

fn difference(a: &[f32], b: &[f32]) -> Vec<f32> {
    a.iter().zip(b).map(|(x, y)| x - y).collect()
}

/// Eight partial sums, which the compiler turns into SIMD.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f32 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f32>() + rest
}
