//! Building of the box hierarchy. Quality saves seconds for the rays of a bake, but not for a first picture.

use obvhs::{
    BvhBuildParams,
    bvh2::{
        Bvh2, builder::build_bvh2_from_tris, leaf_collapser::collapse, node::Bvh2Node,
        reinsertion::ReinsertionOptimizer,
    },
    triangle::Triangle,
};
use std::time::Duration;

/// One triangle per leaf: leaves are merged once the hierarchy is optimized.
const FIRST: BvhBuildParams = BvhBuildParams {
    max_prims_per_leaf: 1,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    ..BvhBuildParams::slow_build()
};

/// One triangle per leaf, neighbors merged along a curve and no more. Five million triangles take a second on two
/// cores, a thirtieth of [`build`]; rays take up to twice as long.
const QUICK: BvhBuildParams =
    BvhBuildParams { max_prims_per_leaf: 1, reinsertion_batch_ratio: 0.0, ..BvhBuildParams::fast_build() };

/// Leaves are large because batches test eight triangles at a time. On the armadillo scene 16 triangles at a traversal
/// cost of 6 gave 15.8 million pairs per second and core; the library's 8 at 3 gave 13.0.
const LEAF_TRIANGLES: u32 = 16;
const TRAVERSAL_COST: f32 = 6.0;

/// Reinsertion continues while a round over all nodes lowers the cost by more than this share.
const LEAST_GAIN: f64 = 0.03;

/// Largest number of rounds, which guarantees termination.
const MOST_ROUNDS: usize = 16;

/// Builds an optimized hierarchy over triangles. The first one merges neighbors along a curve, where boxes of flat walls tie and
/// nest badly: a ray may then meet hundreds of triangles. Reinsertion (Meister and Bittner 2018) repairs the nesting.
pub(super) fn build(triangles: &[Triangle]) -> Bvh2 {
    let mut bvh = build_bvh2_from_tris(triangles, FIRST, &mut Duration::default());
    let mut optimizer = ReinsertionOptimizer::default();
    let mut before = cost(&bvh);
    for _ in 0..MOST_ROUNDS {
        optimizer.run(&mut bvh, 1.0, None);
        let now = cost(&bvh);
        if now > (1.0 - LEAST_GAIN) * before {
            break;
        }
        before = now;
    }
    collapse(&mut bvh, LEAF_TRIANGLES, TRAVERSAL_COST);
    optimizer.run(&mut bvh, 1.0, None);
    bvh
}

/// Builds a hierarchy over triangles quickly.
pub(super) fn build_quickly(triangles: &[Triangle]) -> Bvh2 {
    let mut bvh = build_bvh2_from_tris(triangles, QUICK, &mut Duration::default());
    collapse(&mut bvh, LEAF_TRIANGLES, TRAVERSAL_COST);
    bvh
}

/// Joins two hierarchies; the triangles of the second follow the `triangles` of the first. A far larger object, such as
/// a ground, would spoil the curve along which neighbors are merged.
pub(super) fn joined(a: &Bvh2, triangles: u32, b: &Bvh2) -> Bvh2 {
    let (Some(root_a), Some(root_b)) = (a.nodes.first(), b.nodes.first()) else {
        return if a.nodes.is_empty() { b.clone() } else { a.clone() };
    };
    // With spatial splits a triangle may be in several leaves.
    let (nodes_a, places_a) = (a.nodes.len() as u32, a.primitive_indices.len() as u32);
    let root = Bvh2Node { aabb: root_a.aabb.union(&root_b.aabb), prim_count: 0, first_index: 1, ..*root_a };
    // Both roots follow the common one; then come the other nodes of the first hierarchy and of the second.
    let moved = |node: &Bvh2Node, nodes: u32, places: u32| {
        let by = if node.is_leaf() { places } else { nodes };
        Bvh2Node { first_index: node.first_index + by, ..*node }
    };
    let of_a = |node: &Bvh2Node| moved(node, 2, 0);
    let of_b = |node: &Bvh2Node| moved(node, nodes_a + 1, places_a);
    let roots = [root, of_a(root_a), of_b(root_b)];
    let others = a.nodes[1..].iter().map(of_a).chain(b.nodes[1..].iter().map(of_b));
    let nodes = roots.into_iter().chain(others).collect();
    let primitive_indices =
        a.primitive_indices.iter().copied().chain(b.primitive_indices.iter().map(|&i| i + triangles)).collect();
    Bvh2 {
        nodes,
        primitive_indices,
        max_depth: a.max_depth.max(b.max_depth) + 1,
        uses_spatial_splits: a.uses_spatial_splits || b.uses_spatial_splits,
        ..Bvh2::default()
    }
}

/// Cost of a random ray that meets the bounds: tested boxes and triangles, each counted as one (surface area heuristic,
/// MacDonald and Booth 1990).
pub(super) fn cost(bvh: &Bvh2) -> f64 {
    let Some(root) = bvh.nodes.first() else { return 0.0 };
    let tests = bvh.nodes.iter().map(|node| f64::from(node.aabb.half_area()) * f64::from(node.prim_count.max(1)));
    tests.sum::<f64>() / f64::from(root.aabb.half_area()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    /// A flat square of `side` by `side` squares, tessellated into triangles, in some rotation.
    fn wall(side: u32, [u, v, at]: [Vec3A; 3]) -> Vec<Triangle> {
        let point = |x: u32, y: u32| at + u * (x as f32 / side as f32) + v * (y as f32 / side as f32);
        let square = |i: u32| {
            let (x, y) = (i % side, i / side);
            let [a, b, c, d] = [point(x, y), point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)];
            [Triangle { v0: a, v1: b, v2: c }, Triangle { v0: a, v1: c, v2: d }]
        };
        (0..side * side).flat_map(square).collect()
    }

    /// Six flat walls.
    fn room(side: u32) -> Vec<Triangle> {
        let [x, y, z, o] = [Vec3A::X, Vec3A::Y, Vec3A::Z, Vec3A::ZERO];
        let walls = [[x, y, o], [x, y, z], [y, z, o], [y, z, x], [z, x, o], [z, x, y]];
        walls.into_iter().flat_map(|wall_at| wall(side, wall_at)).collect()
    }

    #[test]
    fn flat_tessellated_walls_are_nested_as_well_as_others() {
        let walls = room(40);
        let library = BvhBuildParams {
            max_prims_per_leaf: LEAF_TRIANGLES,
            collapse_traversal_cost: TRAVERSAL_COST,
            ..BvhBuildParams::slow_build()
        };
        let before = cost(&build_bvh2_from_tris(&walls, library, &mut Duration::default()));
        let now = cost(&build(&walls));
        assert!(now < 60.0, "{now}");
        assert!(before > 4.0 * now, "negative control: the library's own build has {before}, and this {now}");
    }

    #[test]
    fn joined_hierarchies_hold_the_triangles_of_both() {
        let walls = room(4);
        let (first, second) = walls.split_at(70);
        let both = joined(&build(first), 70, &build(second));
        let mut indices = both.primitive_indices.clone();
        indices.sort_unstable();
        assert_eq!(indices, (0..walls.len() as u32).collect::<Vec<_>>());
        // Each leaf contains its triangles, and each node its children.
        for node in &both.nodes {
            let range = node.first_index as usize..;
            let inside = match node.is_leaf() {
                true => both.primitive_indices[range].iter().take(node.prim_count as usize).all(|&i| {
                    let triangle = walls[i as usize].aabb();
                    node.aabb.min.cmple(triangle.min).all() && node.aabb.max.cmpge(triangle.max).all()
                }),
                false => both.nodes[range].iter().take(2).all(|child| {
                    node.aabb.min.cmple(child.aabb.min).all() && node.aabb.max.cmpge(child.aabb.max).all()
                }),
            };
            assert!(inside);
        }
        let leaves: u32 = both.nodes.iter().map(|node| node.prim_count).sum();
        assert_eq!(leaves as usize, walls.len());
        assert_eq!(joined(&build(&[]), 0, &build(first)).nodes.len(), build(first).nodes.len());
    }

    #[test]
    fn nothing_and_a_single_triangle_have_a_hierarchy() {
        assert_eq!((cost(&build(&[])), cost(&build_quickly(&[]))), (0.0, 0.0));
        assert_eq!(build_quickly(&wall(1, [Vec3A::X, Vec3A::Y, Vec3A::ZERO])[..1]).nodes.len(), 1);
        let one = build(&wall(1, [Vec3A::X, Vec3A::Y, Vec3A::ZERO])[..1]);
        assert_eq!(one.nodes.len(), 1);
    }
}
