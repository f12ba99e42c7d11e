//! Visibility cuts of vertices that moved or that a moved object covered, from the bins of the leaves beside them.

use super::vertices::VertexLeaves;
use glam::Vec3;
use lapidary_core::{
    cut::{CutSelector, packed::PackedCuts},
    dataset::Dataset,
    implicit::{EMPTY, Views, disc_forest::DiscForest},
    ray::OPEN,
};
use rayon::prelude::*;
use std::collections::HashMap;

/// Least number of directions per bin.
const DIRECTIONS_OF_A_BIN: usize = 4;

/// Visibility of one leaf along each direction.
struct Sight {
    /// 1 where it sees the sky, else 0.
    sky: Vec<f32>,
    /// 1 above its horizon, else 0.
    above: Vec<f32>,
}

/// The cuts of a dataset, with new ones for the vertices in `renewed`. `open` tells how much of a leaf counts for a
/// vertex: 0 to 1, by vertex and leaf.
pub fn of_bins(
    dataset: &Dataset,
    (forest, views): (&DiscForest, &Views),
    vertices: &VertexLeaves,
    renewed: Vec<u32>,
    open: impl Fn(u32, u32) -> f32 + Sync,
) -> PackedCuts {
    let tree = &dataset.tree;
    let nodes = (DIRECTIONS_OF_A_BIN * views.layout().cells.len()).next_power_of_two().min(tree.len());
    let directions: Vec<Vec3> =
        (nodes..2 * nodes).map(|node| tree.mean_directions()[node].normalize_or_zero()).collect();
    let mut leaves: Vec<u32> = renewed.iter().flat_map(|&vertex| vertices.of(vertex)).map(|(leaf, _)| leaf).collect();
    leaves.sort_unstable();
    leaves.dedup();
    let sight = |&leaf: &u32| (leaf, sight(forest, views, leaf, &directions));
    let sights: HashMap<u32, Sight> = leaves.par_iter().map(sight).collect();
    let criterion = dataset.settings.criterion.of_means(tree.len() / nodes);
    let buffers = || (CutSelector::new(nodes.ilog2(), criterion), [vec![0.0; nodes], vec![0.0; nodes]]);
    let select = |(selector, sums): &mut (CutSelector, [Vec<f32>; 2]), &vertex: &u32| {
        sums.iter_mut().for_each(|sum| sum.fill(0.0));
        for (leaf, weight) in vertices.of(vertex) {
            sights[&leaf].add_to(sums, weight * open(vertex, leaf));
        }
        let [sky, above] = &*sums;
        let shares: Vec<u8> = sky.iter().zip(above).map(|(sky, above)| share_of_sky(*sky, *above)).collect();
        let mut cut = Vec::new();
        selector.select(&shares, &mut cut);
        cut
    };
    let cuts: Vec<Vec<u16>> = renewed.par_iter().map_init(buffers, select).collect();
    dataset.cuts.with(renewed.into_iter().zip(cuts))
}

fn sight(forest: &DiscForest, views: &Views, leaf: u32, directions: &[Vec3]) -> Sight {
    let local_from_world = views.layout().frame_of(&forest.discs()[leaf as usize]).transpose();
    let nodes = views.of_leaf(leaf);
    let seen = |direction: &Vec3| {
        let local = local_from_world * *direction;
        let is_above = local.z > 0.0;
        let is_sky = is_above && nodes[views.layout().cells.cell_of(local)] == EMPTY;
        [is_sky, is_above].map(|is| f32::from(u8::from(is)))
    };
    let (sky, above) = directions.iter().map(seen).map(|[sky, above]| (sky, above)).unzip();
    Sight { sky, above }
}

impl Sight {
    fn add_to(&self, sums: &mut [Vec<f32>; 2], weight: f32) {
        for (sum, own) in sums.iter_mut().zip([&self.sky, &self.above]) {
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own * weight);
        }
    }
}

/// Share of the sky that leaves see in a direction, in units of [`OPEN`], from their summed weights. Only leaves that face the
/// direction count.
fn share_of_sky(sky: f32, above: f32) -> u8 {
    if above > 0.0 { (sky / above * f32::from(OPEN) + 0.5) as u8 } else { 0 }
}
