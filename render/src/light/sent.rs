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
use std::sync::LazyLock;

/// Directions of a node.
pub(crate) const KNOTS: Knots = Knots { side: 16 };
/// Unit directions of the knots.
pub(crate) static DIRECTIONS: LazyLock<[Vec3; KNOTS.len()]> =
    LazyLock::new(|| std::array::from_fn(|knot| KNOTS.direction_of(knot)));
/// Values toward the knots.
pub(crate) type Toward = [Vec3; KNOTS.len()];
/// Least cosine by which a source counts in a node's light toward a direction. It decides where none is seen.
const LEAST_COSINE: f32 = 1e-3;

/// Radiance of nodes by direction, over the brightest channel that the same sources would send there if they were diffuse, as
/// codes of a shared exponent. Times the brightest channel of a node's mean it is the light that it sends there.
#[derive(Clone, Debug)]
pub struct SentByDirection {
    /// By heap index.
    codes: Vec<[u32; KNOTS.len()]>,
}

/// What the sources below a node send toward the knots, weighted by the area that is seen: by direction, and as diffuse surfaces.
struct Seen {
    sent: Toward,
    diffuse: Toward,
}

impl Seen {
    fn source(source: &Source, (diffuse, sent): (Vec3, Toward)) -> Self {
        let area = DIRECTIONS.map(|direction| source.area * source.surfel.normal.dot(direction).max(LEAST_COSINE));
        let scaled = |of: &dyn Fn(usize) -> Vec3| std::array::from_fn(|knot| of(knot) * area[knot]);
        Self { sent: scaled(&|knot| sent[knot]), diffuse: scaled(&|_| diffuse) }
    }

    fn joined([a, b]: &[Self; 2]) -> Self {
        let sum = |a: &Toward, b: &Toward| std::array::from_fn(|knot| a[knot] + b[knot]);
        Self { sent: sum(&a.sent, &b.sent), diffuse: sum(&a.diffuse, &b.diffuse) }
    }

    fn codes(&self) -> [u32; KNOTS.len()] {
        let share = |knot: usize| self.sent[knot] / self.diffuse[knot].max_element().max(f32::MIN_POSITIVE);
        std::array::from_fn(|knot| encode(share(knot)))
    }
}

impl SentByDirection {
    /// Of the radiance that each source would send as a diffuse surface, and what it sends toward the knots.
    pub(crate) fn new(tree: &SourceTree, of_source: impl Fn(usize) -> (Vec3, Toward) + Sync) -> Self {
        let mut codes = vec![[0; KNOTS.len()]; 2 * tree.len()];
        let leaf = |i: usize| Seen::source(&tree.sources()[i], of_source(i));
        let mut level: Vec<Seen> = (0..tree.len()).into_par_iter().map(leaf).collect();
        loop {
            let nodes = level.len();
            codes[nodes..2 * nodes].par_iter_mut().zip(&level).for_each(|(codes, seen)| *codes = seen.codes());
            if nodes == 1 {
                break;
            }
            level = level.par_chunks(2).map(|pair| Seen::joined(pair.as_array().expect("a complete tree"))).collect();
        }
        Self { codes }
    }

    /// Codes of the shares, by heap index; those of index 0 are of no node.
    pub(crate) fn codes(&self) -> &[[u32; KNOTS.len()]] {
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
        SentByDirection::new(&tree, |i| (diffuse[i], [diffuse[i] * times[i]; KNOTS.len()]))
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
    fn eight_shares_are_those_of_one_also_from_the_middle_of_a_node() {
        let sent = back_to_back([Vec3::X, Vec3::ONE], [2.0, 0.7]);
        let mut directions = fibonacci_directions(799);
        directions.push(Vec3::ZERO);
        for eight in directions.chunks_exact(8) {
            let nodes = std::array::from_fn(|i| 1 + i % 3);
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
