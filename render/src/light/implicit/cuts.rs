//! Visibility cuts of vertices that moved, from the bins of the leaves beside them.

use super::vertices::VertexLeaves;
use glam::Vec3;
use lapidary_core::{
    cut::{CutSelector, packed::PackedCuts},
    dataset::Dataset,
    implicit::{CELLS, EMPTY, Views, frame_of},
    ray::OPEN,
    surfel::disc_forest::DiscForest,
};
use rayon::prelude::*;
use std::collections::HashMap;

/// Depth of the nodes whose visibility is looked up: 2,048 directions, some for each cell.
const DEPTH: u32 = 11;

/// What a leaf sees along each direction: nothing below its horizon, something that blocks it, or the sky.
type Sight = Box<[Seen]>;

#[derive(Clone, Copy, PartialEq)]
enum Seen {
    BelowHorizon,
    Blocked,
    Sky,
}

/// The cuts of a dataset, with new ones for the vertices of `is_moved`. Bins are turned by `turn`.
pub fn of_moved(
    dataset: &Dataset,
    (forest, views, turn): (&DiscForest, &Views, f32),
    vertices: &VertexLeaves,
    is_moved: &[bool],
) -> PackedCuts {
    let (tree, height) = (&dataset.tree, dataset.tree.height());
    let nodes = 1 << height.min(DEPTH);
    let directions: Vec<Vec3> =
        (nodes..2 * nodes).map(|node| tree.mean_directions()[node].normalize_or_zero()).collect();
    let moved: Vec<u32> = (0..is_moved.len() as u32).filter(|&vertex| is_moved[vertex as usize]).collect();
    let mut leaves: Vec<u32> = moved.iter().flat_map(|&vertex| vertices.of(vertex)).map(|(leaf, _)| leaf).collect();
    leaves.sort_unstable();
    leaves.dedup();
    let sight = |&leaf: &u32| (leaf, sight(forest, views, turn, leaf, &directions));
    let sights: HashMap<u32, Sight> = leaves.par_iter().map(sight).collect();
    let selector = || (CutSelector::new(height, dataset.settings.criterion), vec![0; tree.len()]);
    let select = |(selector, seen): &mut (CutSelector, Vec<u8>), &vertex: &u32| {
        let around: Vec<_> = vertices.of(vertex).map(|(leaf, weight)| (&sights[&leaf], weight)).collect();
        for (node, leaves) in seen.chunks_exact_mut(tree.len() / nodes).enumerate() {
            leaves.fill(share_of_sky(&around, node));
        }
        let mut cut = Vec::new();
        selector.select(seen, &mut cut);
        cut
    };
    let cuts: Vec<Vec<u16>> = moved.par_iter().map_init(selector, select).collect();
    dataset.cuts.with(moved.into_iter().zip(cuts))
}

fn sight(forest: &DiscForest, views: &Views, turn: f32, leaf: u32, directions: &[Vec3]) -> Sight {
    let local_from_world = frame_of(&forest.discs()[leaf as usize], turn).transpose();
    let nodes = views.of_leaf(leaf);
    let seen = |direction: &Vec3| {
        let local = local_from_world * *direction;
        match local.z > 0.0 {
            false => Seen::BelowHorizon,
            true if nodes[CELLS.cell_of(local)] == EMPTY => Seen::Sky,
            true => Seen::Blocked,
        }
    };
    directions.iter().map(seen).collect()
}

/// Share of the sky that leaves see in a direction, by their weights, in units of [`OPEN`]. Those count that face it.
fn share_of_sky(around: &[(&Sight, f32)], direction: usize) -> u8 {
    let (mut open, mut all) = (0.0, 0.0);
    for (sight, weight) in around {
        let seen = sight[direction];
        open += if seen == Seen::Sky { *weight } else { 0.0 };
        all += if seen == Seen::BelowHorizon { 0.0 } else { *weight };
    }
    if all > 0.0 { (open / all * f32::from(OPEN) + 0.5) as u8 } else { 0 }
}
