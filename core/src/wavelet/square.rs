//! The quadtree of the unit square, and the nonstandard Haar basis on it (wavelet paper, 4.1, Fig. 2b).
//!
//! Functions are normalized: the integral of the square of each over the unit square is one.

use crate::transport::Coefficient;
use glam::{UVec2, Vec2};

/// A square of the quadtree, as its path from the root: a one, then two bits for each level, x below y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(u32);

impl Node {
    /// The whole square.
    pub const ROOT: Self = Self(1);
    /// The deepest level of a node. A [`Function`] has two bits beside the node.
    pub const DEEPEST: u32 = 14;

    /// The node of a level that holds a point of the unit square.
    ///
    /// # Panics
    /// If the level exceeds [`Self::DEEPEST`].
    pub fn at(level: u32, point: Vec2) -> Self {
        assert!(level <= Self::DEEPEST, "a level of the quadtree");
        let cells = 1 << level;
        Self::of_cell(level, (point * cells as f32).as_uvec2().min(UVec2::splat(cells - 1)))
    }

    /// The node of a cell of the grid of a level.
    pub fn of_cell(level: u32, cell: UVec2) -> Self {
        (0..level).rev().fold(Self::ROOT, |node, bit| {
            let UVec2 { x, y } = (cell >> bit) & UVec2::ONE;
            node.child(x + 2 * y)
        })
    }

    /// All nodes of a level, row by row.
    pub fn all(level: u32) -> impl Iterator<Item = Self> {
        let cells = 1 << level;
        (0..cells * cells).map(move |cell| Self::of_cell(level, UVec2::new(cell % cells, cell / cells)))
    }

    /// Halvings from the whole square.
    pub const fn level(self) -> u32 {
        self.0.ilog2() / 2
    }

    /// Child 0 to 3: left and right of the upper half, then of the lower.
    pub const fn child(self, index: u32) -> Self {
        Self(4 * self.0 + index)
    }

    /// The four children.
    pub fn children(self) -> [Self; 4] {
        std::array::from_fn(|index| self.child(index as u32))
    }

    /// The node around this one; `None` for the root.
    pub const fn parent(self) -> Option<Self> {
        if self.0 == 1 { None } else { Some(Self(self.0 / 4)) }
    }

    /// Its cell in the grid of its level.
    pub fn cell(self) -> UVec2 {
        let bits = |shift: u32| (0..self.level()).fold(0, |sum, bit| sum | (self.0 >> (2 * bit + shift) & 1) << bit);
        UVec2::new(bits(0), bits(1))
    }

    /// The point of the unit square at a place of the node, which goes from (0, 0) to (1, 1).
    pub fn point(self, place: Vec2) -> Vec2 {
        (self.cell().as_vec2() + place) * self.side()
    }

    /// Length of its edge; that of the whole square is one.
    pub fn side(self) -> f32 {
        (1 << self.level()) as f32 / (1_u32 << (2 * self.level())) as f32
    }

    /// The function that is constant on the node, and zero elsewhere.
    pub const fn smooth(self) -> Function {
        Function(4 * self.0)
    }

    /// Whether a node lies in this one.
    pub const fn holds(self, other: Self) -> bool {
        other.level() >= self.level() && other.0 >> (2 * (other.level() - self.level())) == self.0
    }
}

/// A function of the basis: the smooth one of a node, or one of its three wavelets. Of the smooth ones only that of the root is in
/// the basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Function(u32);

impl Function {
    /// The function that is one everywhere.
    pub const CONSTANT: Self = Node::ROOT.smooth();

    /// Its number in a file: the path of the support, then two bits.
    pub const fn to_bits(self) -> u32 {
        self.0
    }

    /// The function of a number; `None` if there is none.
    pub const fn from_bits(bits: u32) -> Option<Self> {
        let is_path = bits >= 4 && (bits / 4).ilog2().is_multiple_of(2);
        if is_path && Self(bits).support().level() <= Node::DEEPEST { Some(Self(bits)) } else { None }
    }

    /// Whether it belongs to the basis with this many halvings: the constant, or a wavelet on a node that is halved.
    pub const fn is_in_basis(self, levels: u32) -> bool {
        let is_smooth = self.0.is_multiple_of(4);
        if is_smooth { self.0 == Self::CONSTANT.0 } else { self.support().level() < levels }
    }

    /// The node on which it is not zero.
    pub const fn support(self) -> Node {
        Node(self.0 / 4)
    }

    /// Its value on each child of the support.
    pub fn values(self) -> [f32; 4] {
        let height = 1.0 / self.support().side();
        SIGNS[(self.0 % 4) as usize].map(|sign| sign * height)
    }

    /// Its value at a point of the unit square.
    pub fn at(self, point: Vec2) -> f32 {
        let support = self.support();
        let child = Node::at(support.level() + 1, point);
        if support.holds(child) { self.values()[(child.0 % 4) as usize] } else { 0.0 }
    }
}

/// Signs of the smooth function and of the three wavelets: of left against right, upper against lower, and both.
const SIGNS: [[f32; 4]; 4] = [[1.0; 4], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]];

/// Coefficients in the basis, in no particular order, of a sum of smooth functions of any nodes. A node may be given several times.
///
/// One step up the tree turns the values of four children into the parent's smooth value and three wavelets.
pub fn transform<T: Coefficient>(smooth: &mut Vec<(Node, T)>, mut found: impl FnMut(Function, T)) {
    // Deeper nodes have longer paths, so they come last.
    smooth.sort_unstable_by_key(|(node, _)| *node);
    while let Some(&(node, _)) = smooth.last() {
        let Some(parent) = node.parent() else { break };
        let mut children = [T::ZERO; 4];
        let mut rest = smooth.len();
        while let Some(&(node, value)) = smooth[..rest].last().filter(|(node, _)| node.parent() == Some(parent)) {
            let child = &mut children[(node.0 % 4) as usize];
            *child = *child + value;
            rest -= 1;
        }
        smooth.truncate(rest);
        let of_kind = |kind: usize| {
            (0..4).map(|child| children[child] * (0.5 * SIGNS[kind][child])).fold(T::ZERO, |sum, value| sum + value)
        };
        (1..4).for_each(|kind| found(Function(4 * parent.0 + kind as u32), of_kind(kind)));
        let place = smooth.partition_point(|(node, _)| *node <= parent);
        smooth.insert(place, (parent, of_kind(0)));
    }
    let constant = smooth.drain(..).fold(T::ZERO, |sum, (_, value)| sum + value);
    found(Function::CONSTANT, constant);
}

/// Coefficients of a sum of products of smooth functions, one node for each of several squares. Each square is transformed in turn, so
/// functions of different squares differ in level ("standard" between them, 4.1). Products of the same functions are added.
pub fn transform_products<const N: usize, T: Coefficient>(products: &[([Node; N], T)]) -> Vec<([Function; N], T)> {
    let mut terms: Vec<([u32; N], T)> =
        products.iter().map(|(nodes, value)| (nodes.map(|node| node.0), *value)).collect();
    for square in 0..N {
        let others = |key: &[u32; N]| {
            let mut others = *key;
            others[square] = 0;
            others
        };
        terms.sort_unstable_by_key(|(key, _)| others(key));
        let mut transformed = Vec::with_capacity(terms.len());
        for alike in terms.chunk_by(|(a, _), (b, _)| others(a) == others(b)) {
            let mut smooth: Vec<(Node, T)> = alike.iter().map(|(key, value)| (Node(key[square]), *value)).collect();
            transform(&mut smooth, |function, value| {
                let mut key = alike[0].0;
                key[square] = function.0;
                transformed.push((key, value));
            });
        }
        terms = transformed;
    }
    terms.into_iter().map(|(key, value)| (key.map(Function), value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn transformed(smooth: &[(Node, f32)]) -> BTreeMap<Function, f32> {
        let mut found = BTreeMap::new();
        transform(&mut smooth.to_vec(), |function, value| *found.entry(function).or_insert(0.0) += value);
        found
    }

    fn at(coefficients: &BTreeMap<Function, f32>, point: Vec2) -> f32 {
        coefficients.iter().map(|(function, value)| function.at(point) * value).sum()
    }

    #[test]
    fn cells_points_and_parents_belong_together() {
        for level in 0..5 {
            for (x, y) in (0..1 << level).flat_map(|y| (0..1 << level).map(move |x| (x, y))) {
                let node = Node::of_cell(level, UVec2::new(x, y));
                assert_eq!((node.level(), node.cell()), (level, UVec2::new(x, y)));
                assert_eq!(Node::at(level, node.point(Vec2::new(0.3, 0.9))), node);
                assert!(node.children().iter().all(|child| child.parent() == Some(node) && node.holds(*child)));
                assert!(level == 0 || !node.holds(node.parent().unwrap()));
            }
        }
        assert_eq!(Node::at(3, Vec2::ONE), Node::of_cell(3, UVec2::splat(7)), "the edge belongs to the last cell");
    }

    /// Some nodes of several levels, with values, one of them twice.
    fn scattered() -> Vec<(Node, f32)> {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut nodes: Vec<_> =
            (0..40).map(|_| (Node::at(rng.u32(0..6), Vec2::new(rng.f32(), rng.f32())), rng.f32() - 0.4)).collect();
        nodes.push(nodes[3]);
        nodes
    }

    #[test]
    fn coefficients_give_the_function_back() {
        let nodes = scattered();
        let coefficients = transformed(&nodes);
        let mut rng = fastrand::Rng::with_seed(6);
        let differs = |coefficients: &BTreeMap<Function, f32>, point| {
            let expected: f32 = nodes.iter().map(|(node, value)| node.smooth().at(point) * value).sum();
            (at(coefficients, point) - expected).abs()
        };
        let points: Vec<Vec2> = (0..200).map(|_| Vec2::new(rng.f32(), rng.f32())).collect();
        assert!(points.iter().all(|&point| differs(&coefficients, point) < 1e-4));
        let mut without = coefficients.clone();
        without.remove(&Function::CONSTANT);
        assert!(points.iter().any(|&point| differs(&without, point) > 0.1), "negative control");
    }

    #[test]
    fn squares_are_kept() {
        // Nodes of one level do not overlap, so the square of the sum is the sum of squares (Parseval).
        let nodes: Vec<_> =
            (0..64).map(|i| (Node::of_cell(3, UVec2::new(i % 8, i / 8)), (i * i % 11) as f32)).collect();
        let squares = |values: &mut dyn Iterator<Item = f32>| values.map(|value| value * value).sum::<f32>();
        let expected = squares(&mut nodes.iter().map(|(_, value)| *value));
        let mut found = transformed(&nodes);
        assert!((squares(&mut found.values().copied()) / expected - 1.0).abs() < 1e-5);
        *found.get_mut(&Function::CONSTANT).unwrap() *= 1.01;
        assert!((squares(&mut found.values().copied()) / expected - 1.0).abs() > 1e-3, "negative control");
    }

    #[test]
    fn products_give_the_function_back() {
        let nodes = scattered();
        let pairs: Vec<([Node; 2], f32)> =
            nodes.iter().zip(nodes.iter().cycle().skip(7)).map(|((a, value), (b, _))| ([*a, *b], *value)).collect();
        let terms = transform_products(&pairs);
        let mut rng = fastrand::Rng::with_seed(9);
        let mut point = || Vec2::new(rng.f32(), rng.f32());
        let mut most_swapped = 0.0_f32;
        for (p, q) in (0..100).map(|_| (point(), point())) {
            let expected: f32 = pairs.iter().map(|([a, b], v)| a.smooth().at(p) * b.smooth().at(q) * v).sum();
            let found: f32 = terms.iter().map(|([a, b], value)| a.at(p) * b.at(q) * value).sum();
            let swapped: f32 = terms.iter().map(|([a, b], value)| b.at(p) * a.at(q) * value).sum();
            assert!((found - expected).abs() < 2e-3, "{found} for {expected}");
            most_swapped = most_swapped.max((swapped - expected).abs());
        }
        assert!(most_swapped > 0.1, "negative control: swapped squares");
    }

    #[test]
    fn functions_have_unit_norm_and_do_not_overlap() {
        let functions: Vec<Function> = transformed(&[(Node::of_cell(2, UVec2::ONE), 1.0)]).into_keys().collect();
        let inner = |a: Function, b: Function| {
            let place = |i: u32| (i as f32 + 0.5) / 8.0;
            let points = (0..64).map(|i| Vec2::new(place(i % 8), place(i / 8)));
            points.map(|point| a.at(point) * b.at(point)).sum::<f32>() / 64.0
        };
        for &a in &functions {
            for &b in &functions {
                assert!((inner(a, b) - f32::from(u8::from(a == b))).abs() < 1e-5, "{a:?} {b:?}");
            }
        }
    }
}
