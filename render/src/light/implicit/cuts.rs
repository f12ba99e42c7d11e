//! Visibility cuts of vertices that moved, from the bins of the leaves beside them.

use super::vertices::VertexLeaves;
use glam::{Mat3, Vec3};
use lapidary_core::{
    cut::{CutSelector, packed::PackedCuts},
    dataset::Dataset,
    implicit::{CELLS, EMPTY, Views, frame_of},
    ray::OPEN,
    surfel::disc_forest::DiscForest,
};
use rayon::prelude::*;

/// Depth of the nodes whose visibility is looked up: 2,048 directions, some for each cell.
const DEPTH: u32 = 11;

/// The cuts of a dataset, with new ones for the vertices of `is_moved`.
pub fn of_moved(
    dataset: &Dataset,
    forest: &DiscForest,
    views: &Views,
    vertices: &VertexLeaves,
    is_moved: &[bool],
) -> PackedCuts {
    let (tree, height) = (&dataset.tree, dataset.tree.height());
    let depth = height.min(DEPTH);
    let nodes = 1 << depth;
    let directions: Vec<Vec3> =
        (nodes..2 * nodes).map(|node| tree.mean_directions()[node].normalize_or_zero()).collect();
    let frames: Vec<Mat3> = forest.discs().iter().map(|disc| frame_of(disc, 0.0)).collect();
    let moved: Vec<u32> = (0..is_moved.len() as u32).filter(|&vertex| is_moved[vertex as usize]).collect();
    let selector = || (CutSelector::new(height, dataset.settings.criterion), vec![0; tree.len()]);
    let select = |(selector, leaves): &mut (CutSelector, Vec<u8>), &vertex: &u32| {
        let around: Vec<_> = vertices.of(vertex).collect();
        for (direction, leaves) in directions.iter().zip(leaves.chunks_exact_mut(tree.len() / nodes)) {
            leaves.fill(seen(&around, &frames, views, *direction));
        }
        let mut cut = Vec::new();
        selector.select(leaves, &mut cut);
        cut
    };
    let cuts: Vec<Vec<u16>> = moved.par_iter().map_init(selector, select).collect();
    dataset.cuts.with(moved.into_iter().zip(cuts))
}

/// Share of the sky that is seen in a direction, in units of [`OPEN`], by leaves and their weights. Those count that face it.
fn seen(around: &[(u32, f32)], frames: &[Mat3], views: &Views, direction: Vec3) -> u8 {
    let (mut open, mut all) = (0.0, 0.0);
    for &(leaf, weight) in around {
        let local = frames[leaf as usize].transpose() * direction;
        if local.z > 0.0 {
            let is_open = views.of_leaf(leaf)[CELLS.cell_of(local)] == EMPTY;
            open += if is_open { weight } else { 0.0 };
            all += weight;
        }
    }
    if all > 0.0 { (open / all * f32::from(OPEN) + 0.5) as u8 } else { 0 }
}
