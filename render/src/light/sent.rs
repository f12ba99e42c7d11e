//! Light that surface sources send by direction, for every node of their tree: shares of what the brightest channel of diffuse
//! sources would send, at knots of directions in the world's frame.

use glam::Vec3;
use lapidary_core::{
    color::shared_exponent::{decode, encode},
    simd::{Lanes, Vec3x8},
    sources::{Source, SourceTree},
    sphere::octahedron::{Knots, KnotsX8},
};
use rayon::prelude::*;
use std::{array::from_fn, sync::LazyLock};

/// Directions of a node.
pub(crate) const KNOTS: Knots = Knots { side: 16 };
/// Unit directions of the knots.
pub(crate) static DIRECTIONS: LazyLock<[Vec3; KNOTS.len()]> =
    LazyLock::new(|| from_fn(|knot| KNOTS.direction_of(knot)));
/// Values toward the knots.
pub(crate) type Toward = [Vec3; KNOTS.len()];
/// Least cosine by which a source counts in a node's light toward a direction. It decides where none is seen.
const LEAST_COSINE: f32 = 1e-3;

/// Radiance of nodes by direction, over the brightest channel that the same sources would send there if they were diffuse, as
/// codes of a shared exponent. Times the brightest channel of a node's mean it is the light that it sends there.
#[derive(Clone, Debug)]
pub struct SentByDirection {
    /// By heap index.
    codes: Vec<Codes>,
}

/// Codes of a node.
type Codes = [u32; KNOTS.len()];
/// Sources below a node whose light stays in the cache until that of the node is known.
const SUBTREE: usize = 64;

/// What the sources below a node send toward the knots, weighted by the area that is seen: by direction, and as diffuse surfaces.
struct Seen {
    sent: Channels,
    diffuse: Channels,
}

/// Values toward the knots, by channel: the compiler makes loops over them wide.
type Channels = [[f32; KNOTS.len()]; 3];

impl Seen {
    fn source(source: &Source, diffuse: Vec3, sent: impl Fn(usize) -> Vec3) -> Self {
        let mut seen = Self { sent: [[0.0; KNOTS.len()]; 3], diffuse: [[0.0; KNOTS.len()]; 3] };
        for (knot, direction) in DIRECTIONS.iter().enumerate() {
            let area = source.area * source.surfel.normal.dot(*direction).max(LEAST_COSINE);
            for (channels, value) in [(&mut seen.sent, sent(knot)), (&mut seen.diffuse, diffuse)] {
                channels.iter_mut().zip((value * area).to_array()).for_each(|(channel, value)| channel[knot] = value);
            }
        }
        seen
    }

    fn joined([a, b]: &[Self; 2]) -> Self {
        let sum = |a: &Channels, b: &Channels| from_fn(|channel| from_fn(|knot| a[channel][knot] + b[channel][knot]));
        Self { sent: sum(&a.sent, &b.sent), diffuse: sum(&a.diffuse, &b.diffuse) }
    }

    fn codes(&self) -> Codes {
        let toward = |[x, y, z]: &Channels, knot: usize| Vec3::new(x[knot], y[knot], z[knot]);
        let diffuse = |knot| toward(&self.diffuse, knot).max_element().max(f32::MIN_POSITIVE);
        from_fn(|knot| encode(toward(&self.sent, knot) / diffuse(knot)))
    }
}

/// The levels of each of `roots` trees, from codes that begin with those of the roots.
fn levels(mut codes: &mut [Codes], roots: usize) -> Vec<Vec<&mut [Codes]>> {
    let mut trees: Vec<_> = (0..roots).map(|_| Vec::new()).collect();
    let mut of_each = 1;
    while !codes.is_empty() {
        let (level, deeper) = codes.split_at_mut(roots * of_each);
        trees.iter_mut().zip(level.chunks_mut(of_each)).for_each(|(tree, level)| tree.push(level));
        (codes, of_each) = (deeper, 2 * of_each);
    }
    trees
}

/// Fills the levels of a tree with what is seen of its leaves, and returns what is seen of its root.
fn fill(levels: Vec<&mut [Codes]>, mut seen: Vec<Seen>) -> Seen {
    for level in levels.into_iter().rev() {
        if level.len() < seen.len() {
            seen = joined(&seen);
        }
        level.iter_mut().zip(&seen).for_each(|(codes, seen)| *codes = seen.codes());
    }
    seen.pop().expect("a root")
}

/// What is seen of each two nodes.
fn joined(seen: &[Seen]) -> Vec<Seen> {
    seen.as_chunks().0.iter().map(Seen::joined).collect()
}

impl SentByDirection {
    /// Of the radiance that each source would send as a diffuse surface, and what it sends toward each knot.
    pub(crate) fn new<F: Fn(usize) -> Vec3>(tree: &SourceTree, of_source: impl Fn(usize) -> (Vec3, F) + Sync) -> Self {
        let mut codes = vec![[0; KNOTS.len()]; 2 * tree.len()];
        let leaf = |i: usize| {
            let (diffuse, sent) = of_source(i);
            Seen::source(&tree.sources()[i], diffuse, sent)
        };
        let size = SUBTREE.min(tree.len());
        let roots = tree.len() / size;
        let (above, below) = codes.split_at_mut(roots);
        let subtrees = levels(below, roots).into_par_iter().enumerate();
        let of_root = |(root, levels)| fill(levels, (root * size..(root + 1) * size).map(leaf).collect());
        let seen: Vec<Seen> = subtrees.map(of_root).collect();
        fill(levels(&mut above[1..], 1).pop().expect("one tree"), seen);
        Self { codes }
    }

    /// Codes of the shares, by heap index; those of index 0 are of no node.
    pub(crate) fn codes(&self) -> &[Codes] {
        &self.codes
    }

    /// Share that a node sends in a direction.
    pub fn share(&self, node: usize, direction: Vec3) -> Vec3 {
        let of_node = &self.codes[node];
        KNOTS.around(direction).iter().map(|&(knot, weight)| decode(of_node[knot]) * weight).sum()
    }

    /// [`Self::share`] of eight nodes, each in its direction.
    #[inline(always)]
    pub(crate) fn shares<L: Lanes>(&self, nodes: [usize; 8], direction: Vec3x8<L>) -> Vec3x8<L> {
        let KnotsX8 { first, right, down } = KNOTS.around_x8(direction);
        let mut sums = [[0.0; 8]; 3];
        for (aside, below) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let mut codes = [0; 8];
            for ((code, node), first) in codes.iter_mut().zip(nodes).zip(first) {
                *code = self.codes[node][(first + below * KNOTS.side + aside) % KNOTS.len()];
            }
            for i in 0..8 {
                let [x, y] = [
                    if aside == 1 { right[i] } else { 1.0 - right[i] },
                    if below == 1 { down[i] } else { 1.0 - down[i] },
                ];
                let color = decode(codes[i]) * (x * y);
                sums[0][i] += color.x;
                sums[1][i] += color.y;
                sums[2][i] += color.z;
            }
        }
        let [x, y, z] = sums;
        Vec3x8 { x: L::new(x), y: L::new(y), z: L::new(z) }
    }

    /// Share that a node sends toward a knot.
    pub(crate) fn toward(&self, node: usize, knot: usize) -> Vec3 {
        decode(self.codes[node][knot])
    }

    /// The largest share of a node, in any direction and channel.
    pub(crate) fn largest(&self, node: usize) -> f32 {
        (0..KNOTS.len()).map(|knot| self.toward(node, knot).max_element()).fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{sphere::fibonacci_directions, surfel::Surfel};
    use wide::f32x8;

    /// Two sources back to back, of the radiance of diffuse sources and `times` as much.
    fn back_to_back(diffuse: [Vec3; 2], times: [f32; 2]) -> SentByDirection {
        let source = |up: f32| Source {
            surfel: Surfel { position: Vec3::ZERO, normal: Vec3::Y * up, ..Default::default() },
            area: 1.0,
            spacing: 1.0,
        };
        let tree = SourceTree::new(&[1.0, -1.0].map(source));
        SentByDirection::new(&tree, |i| (diffuse[i], move |_| diffuse[i] * times[i]))
    }

    #[test]
    fn a_node_sends_what_its_seen_sources_send() {
        let sent = back_to_back([Vec3::ONE; 2], [3.0, 0.5]);
        let toward = |node: usize, direction: Vec3| sent.share(node, direction.normalize()).x;
        assert!((toward(1, Vec3::new(0.3, 1.0, 0.2)) - 3.0).abs() < 0.02, "{}", toward(1, Vec3::Y));
        assert!((toward(1, Vec3::new(0.3, -1.0, 0.2)) - 0.5).abs() < 0.02);
        assert!((toward(2, Vec3::NEG_Y) - 3.0).abs() < 0.01, "a leaf has no other side");
        assert!((toward(3, Vec3::Y) - 0.5).abs() < 0.01, "negative control");
        assert!((sent.largest(1) - 3.0).abs() < 0.02 && (sent.largest(3) - 0.5).abs() < 0.01);
    }

    #[test]
    fn every_node_of_a_tree_of_many_subtrees_sends_the_mean_of_its_sources() {
        for count in [1, SUBTREE, 4 * SUBTREE] {
            let at = |i: usize| Surfel { position: Vec3::X * i as f32, normal: Vec3::Y, ..Default::default() };
            let sources: Vec<Source> = (0..count).map(|i| Source { surfel: at(i), area: 1.0, spacing: 1.0 }).collect();
            let tree = SourceTree::new(&sources);
            let times = |i: usize| (1 + i) as f32;
            let sent = SentByDirection::new(&tree, |i| (Vec3::ONE, move |_| Vec3::splat(times(i))));
            let mean = |node: usize| {
                let of_each = count >> node.ilog2();
                let first = (node * of_each) - count;
                (first..first + of_each).map(times).sum::<f32>() / of_each as f32
            };
            for node in 1..2 * count {
                let off = |expected: f32| (sent.toward(node, 37).x / expected - 1.0).abs();
                assert!(off(mean(node)) < 1.0 / 256.0, "{node} of {count}");
                let beside = mean(if node == 1 { 1 } else { node ^ 1 });
                let is_alike = (beside / mean(node) - 1.0).abs() < 0.01;
                assert!(is_alike || off(beside) > 1.0 / 256.0, "negative control, {node} of {count}");
            }
        }
    }

    #[test]
    fn eight_shares_are_those_of_one_also_from_the_middle_of_a_node() {
        let sent = back_to_back([Vec3::X, Vec3::ONE], [2.0, 0.7]);
        let mut directions = fibonacci_directions(799);
        directions.push(Vec3::ZERO);
        for eight in directions.chunks_exact(8) {
            let nodes = from_fn(|i| 1 + i % 3);
            let found = sent.shares(nodes, Vec3x8::<f32x8>::from_array(eight.try_into().unwrap()));
            for (i, &direction) in eight.iter().enumerate() {
                assert!((found.lane(i) - sent.share(nodes[i], direction)).length() < 1e-4, "{direction}");
            }
        }
    }

    #[test]
    fn a_bright_channel_leaves_the_others_as_they_are_and_darkness_is_dark() {
        // Of a red metal: green and blue shine at the horizon alone.
        let sent = back_to_back([Vec3::new(0.8, 1e-5, 0.0); 2], [1.0; 2]);
        assert!((sent.toward(2, 0) - Vec3::X).length() < 1e-3, "{}", sent.toward(2, 0));
        assert_eq!(back_to_back([Vec3::ZERO; 2], [1.0; 2]).toward(1, 0), Vec3::ZERO);
    }
}
