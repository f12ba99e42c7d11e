//! Visibility cuts of vertices that moved or that a moved object covered, from the bins of the leaves beside them.

use super::vertices::VertexLeaves;
use glam::Vec3;
use lapidary_core::{
    cut::{CutCriterion, CutSelector, packed::PackedCuts},
    dataset::Dataset,
    implicit::{BinLayout, EMPTY, Views, disc_forest::DiscForest},
    ray::OPEN,
};
use rayon::prelude::*;
use std::collections::HashMap;

/// Least number of directions per bin.
const DIRECTIONS_OF_A_BIN: usize = 4;

/// Vertices that get new cuts, and what of the leaves beside them counts.
pub struct NewCuts<'a> {
    /// The dataset with its cuts as baked.
    pub dataset: &'a Dataset,
    /// The leaves beside all vertices.
    pub beside: &'a VertexLeaves,
    /// Those that get cuts, in ascending order.
    pub vertices: Vec<u32>,
    /// Whether each vertex of the scene moved; then all of its leaves count.
    pub is_moved: &'a [bool],
    /// Open share of each leaf for other vertices, 0 to 1.
    pub open: &'a [f32],
}

/// Visibility of one leaf along each direction.
struct Sight {
    /// 1 where it sees the sky, else 0.
    sky: Vec<f32>,
    /// 1 above its horizon, else 0.
    above: Vec<f32>,
}

impl NewCuts<'_> {
    /// Directions that stand for the leaves of the tree below equal nodes of it.
    pub fn directions(&self, layout: BinLayout) -> Vec<Vec3> {
        let tree = &self.dataset.tree;
        let nodes = (DIRECTIONS_OF_A_BIN * layout.cells.len()).next_power_of_two().min(tree.len());
        (nodes..2 * nodes).map(|node| tree.mean_directions()[node].normalize_or_zero()).collect()
    }

    /// When a node over so many directions is fine enough.
    pub fn criterion(&self, directions: usize) -> CutCriterion {
        self.dataset.settings.criterion.of_means(self.dataset.tree.len() / directions)
    }

    /// Whether a vertex moved.
    pub fn is_moved(&self, vertex: u32) -> bool {
        self.is_moved[vertex as usize]
    }

    /// The cuts of the dataset, with new ones made on the cores. The twin on an adapter is `GpuForest::cuts`.
    pub fn of_bins(self, forest: &DiscForest, views: &Views) -> PackedCuts {
        let directions = self.directions(views.layout());
        let beside = self.vertices.iter().flat_map(|&vertex| self.beside.of(vertex));
        let mut leaves: Vec<u32> = beside.map(|(leaf, _)| leaf).collect();
        leaves.sort_unstable();
        leaves.dedup();
        let sight = |&leaf: &u32| (leaf, sight(forest, views, leaf, &directions));
        let sights: HashMap<u32, Sight> = leaves.par_iter().map(sight).collect();
        let (nodes, criterion) = (directions.len(), self.criterion(directions.len()));
        let buffers = || (CutSelector::new(nodes.ilog2(), criterion), [vec![0.0; nodes], vec![0.0; nodes]]);
        let select = |(selector, sums): &mut (CutSelector, [Vec<f32>; 2]), &vertex: &u32| {
            sums.iter_mut().for_each(|sum| sum.fill(0.0));
            for (leaf, weight) in self.beside.of(vertex) {
                let open = if self.is_moved(vertex) { 1.0 } else { self.open[leaf as usize] };
                sights[&leaf].add_to(sums, weight * open);
            }
            let [sky, above] = &*sums;
            let shares: Vec<u8> = sky.iter().zip(above).map(|(sky, above)| share_of_sky(*sky, *above)).collect();
            let mut cut = Vec::new();
            selector.select(&shares, &mut cut);
            cut
        };
        let cuts: Vec<Vec<u16>> = self.vertices.par_iter().map_init(buffers, select).collect();
        self.dataset.cuts.with(self.vertices.into_iter().zip(cuts))
    }
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
