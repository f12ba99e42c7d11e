//! Divides points into cells of small squared error: divisive k-means, the worst cell first.

use glam::Vec3;
use lapidary_core::surfel::Surfel;
use std::{cmp::Ordering, collections::BinaryHeap};

/// Smallest number of hits per cell; fewer would not determine its width.
const LEAST_HITS: usize = 8;
/// Number of axis directions; points facing each of them are divided separately.
const SIDES: usize = 6;

/// The end of a segment.
pub(super) struct WeightedHit {
    position: Vec3,
    side: usize,
    /// Squared error of its light, in radians, per squared meter between the hit and the assumed center of its light.
    weight: f32,
}

impl WeightedHit {
    /// For a segment of positive length in meters.
    pub fn new(end: &Surfel, length: f32) -> Self {
        Self { position: end.position, side: side_of(end.normal), weight: length.powi(-2) }
    }
}

/// A binary tree of cells for each axis direction.
pub(super) struct Cells {
    /// The first nodes are the roots.
    nodes: Vec<Node>,
}

enum Node {
    /// Points below a coordinate on an axis are in the first of two adjacent nodes, others in the second.
    Parent { axis: usize, at: f32, first: usize },
    /// Its width in meters.
    Cell(f32),
}

impl Cells {
    /// Divides the hits into at most about `count` cells.
    pub fn new(mut hits: Vec<WeightedHit>, count: usize) -> Self {
        hits.sort_unstable_by_key(|hit| hit.side);
        let mut nodes: Vec<Node> = (0..SIDES).map(|_| Node::Cell(f32::INFINITY)).collect();
        let sides = hits.chunk_by_mut(|a, b| a.side == b.side);
        let mut clusters: BinaryHeap<Cluster> = sides.map(|side| Cluster::new(side[0].side, side)).collect();
        clusters.iter().for_each(|cluster| nodes[cluster.node] = Node::Cell(cluster.width));
        while nodes.len() < 2 * count {
            let Some(Cluster { node, members, axis, mean, .. }) = clusters.pop() else { break };
            let Some((at, below)) = split(members, axis, mean) else { continue };
            let first = nodes.len();
            nodes[node] = Node::Parent { axis, at, first };
            for half in <[&mut [WeightedHit]; 2]>::from(members.split_at_mut(below)) {
                let half = Cluster::new(nodes.len(), half);
                nodes.push(Node::Cell(half.width));
                clusters.push(half);
            }
        }
        Self { nodes }
    }

    /// Width in meters of the cell of a point: the root of the mean squared distance of its hits from their mean, both weighted by
    /// error. Infinite with too few hits.
    pub fn width_at(&self, place: &Surfel) -> f32 {
        let mut node = side_of(place.normal);
        loop {
            match self.nodes[node] {
                Node::Parent { axis, at, first } => node = first + usize::from(place.position[axis] >= at),
                Node::Cell(width) => return width,
            }
        }
    }

    /// Finite widths of all cells.
    pub fn widths(&self) -> impl Iterator<Item = f32> {
        let width = |node: &Node| if let Node::Cell(width) = node { Some(*width) } else { None };
        self.nodes.iter().filter_map(width).filter(|width| width.is_finite())
    }
}

/// Index of the axis direction closest to a normal.
fn side_of(normal: Vec3) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}

/// Moves hits below a coordinate on an axis to the front. Returns the coordinate and their number. The coordinate is their mean, or
/// their median if the mean leaves too few on one side, as with a few short segments at an edge. `None` if the median does too.
fn split(members: &mut [WeightedHit], axis: usize, mean: f32) -> Option<(f32, usize)> {
    let mut at = mean;
    for _ in 0..2 {
        let below = partition(members, |hit| hit.position[axis] < at);
        if below.min(members.len() - below) >= LEAST_HITS {
            return Some((at, below));
        }
        let by_place = |a: &WeightedHit, b: &WeightedHit| a.position[axis].total_cmp(&b.position[axis]);
        at = members.select_nth_unstable_by(members.len() / 2, by_place).1.position[axis];
    }
    None
}

/// Moves members that satisfy `is_first` to the front, and returns their number.
fn partition(members: &mut [WeightedHit], is_first: impl Fn(&WeightedHit) -> bool) -> usize {
    let mut count = 0;
    for i in 0..members.len() {
        if is_first(&members[i]) {
            members.swap(i, count);
            count += 1;
        }
    }
    count
}

/// A group of close hits.
struct Cluster<'a> {
    node: usize,
    members: &'a mut [WeightedHit],
    /// Sum of their squared errors if all light came from their mean.
    error: f32,
    /// The axis of their largest spread, and their mean on it.
    axis: usize,
    mean: f32,
    width: f32,
}

impl<'a> Cluster<'a> {
    fn new(node: usize, members: &'a mut [WeightedHit]) -> Self {
        let sum = |of: &dyn Fn(&WeightedHit) -> Vec3| members.iter().map(|l| of(l) * l.weight).sum::<Vec3>();
        let weight = sum(&|_| Vec3::ONE).x;
        let mean = sum(&|l| l.position) / weight;
        let squares = sum(&|l| (l.position - mean) * (l.position - mean));
        let (axis, error) = (squares.max_position(), squares.element_sum());
        let width = if members.len() < LEAST_HITS { f32::INFINITY } else { (error / weight).sqrt() };
        Self { node, members, error, axis, mean: mean[axis], width }
    }
}

impl Ord for Cluster<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(self.node.cmp(&other.node))
    }
}

impl PartialOrd for Cluster<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cluster<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cluster<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    fn surfel(position: Vec3, normal: Vec3) -> Surfel {
        Surfel { position, normal, ..Default::default() }
    }

    /// Hits spread over a square of two meters, by segments of `length`.
    fn hits(normal: Vec3, length: impl Fn(Vec3) -> f32) -> Vec<WeightedHit> {
        let mut rng = fastrand::Rng::with_seed(7);
        let mut coordinate = || 2.0 * rng.f32() - 1.0;
        let places = std::iter::repeat_with(|| Vec3::new(coordinate(), 0.0, coordinate())).take(40_000);
        places.map(|p| WeightedHit::new(&surfel(p, normal), length(p))).collect()
    }

    #[test]
    fn cells_of_even_error_are_alike_and_those_of_short_segments_small() {
        let width = |cells: &Cells, x: f32| {
            let at = |i: i32, j: i32| Vec3::new(x + 0.02 * i as f32, 0.0, 0.04 * j as f32);
            let places = (-10..=10).flat_map(|i| (-20..=20).map(move |j| at(i, j)));
            places.map(|p| cells.width_at(&surfel(p, Vec3::Y))).sum::<f32>() / 861.0
        };
        let even = Cells::new(hits(Vec3::Y, |_| 1.0), 400);
        // One square meter per hundred cells: the root of two twelfths of a cell's side of 0.1.
        let expected = 0.1 * (1.0_f32 / 6.0).sqrt();
        for x in [-0.5, 0.5] {
            assert!((width(&even, x) / expected - 1.0).abs() < 0.25, "{} for {expected}", width(&even, x));
        }
        // Each hit has sixteen times the error: the best density of centers is the square root of that, and their distance the root
        // again.
        let graded = Cells::new(hits(Vec3::Y, |p| if p.x < 0.0 { 0.25 } else { 1.0 }), 400);
        let ratio = width(&graded, 0.5) / width(&graded, -0.5);
        assert!((1.6..2.6).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_few_short_segments_at_an_edge_do_not_keep_a_cell_whole() {
        let at_edge =
            (0..4).map(|i| WeightedHit::new(&surfel(Vec3::new(1.0 + 1e-3 * i as f32, 0.0, 0.0), Vec3::Y), 0.01));
        let cells = Cells::new(hits(Vec3::Y, |_| 2.0).into_iter().take(500).chain(at_edge).collect(), 100);
        let width = cells.width_at(&surfel(Vec3::ZERO, Vec3::Y));
        // Two meters divided into a hundred cells of at least eight hits.
        assert!((0.03..0.3).contains(&width), "{width}");
        assert!(matches!(cells.nodes[2], Node::Parent { .. }), "the root of the side is divided");
    }

    #[test]
    fn sides_are_divided_apart_and_where_nothing_lands_cells_are_infinitely_wide() {
        let cells = Cells::new(hits(Vec3::Y, |_| 1.0), 100);
        assert!(cells.width_at(&surfel(Vec3::ZERO, Vec3::Y)).is_finite());
        assert_eq!(cells.width_at(&surfel(Vec3::ZERO, Vec3::NEG_Y)), f32::INFINITY);
        assert_eq!(Cells::new(Vec::new(), 100).width_at(&surfel(Vec3::ZERO, Vec3::Y)), f32::INFINITY);
    }
}
