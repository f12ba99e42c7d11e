//! Chunks to packed cuts, within what a texture and the byte budget hold.

use super::BakeError;
use crate::checkpoint::Chunk;
use lapidary_core::cut::{
    packed::{NODES_PER_TEXEL, PackedCuts, TEXTURE_WIDTH},
    prune,
};
use rayon::prelude::*;

/// All cuts, and sums over their points.
pub(super) struct Packed {
    pub cuts: PackedCuts,
    /// Number of points.
    pub points: usize,
    pub nodes: u64,
    pub max_cut: usize,
    pub squared_error: f64,
    pub rays: u64,
    /// Entry `i` counts cuts of `2^i` to `2^(i+1) - 1` nodes.
    pub histogram: Vec<u64>,
}

impl Packed {
    pub fn mean_cut(&self) -> f64 {
        self.nodes as f64 / self.points.max(1) as f64
    }

    /// Bytes of nodes, padding and offsets.
    pub fn bytes(&self) -> u64 {
        (2 * self.cuts.nodes().len() + 4 * self.cuts.offsets().len()) as u64
    }
}

/// One-node cuts of zero, for a part that is not baked.
pub(super) fn unbaked(points: usize) -> Vec<Chunk> {
    vec![Chunk { nodes: vec![0; points], lengths: vec![1; points], ..Chunk::default() }]
}

/// The cut of each point.
pub(super) fn concatenate(chunks: &[Chunk]) -> Vec<Vec<u16>> {
    let mut all = Vec::with_capacity(chunks.iter().map(|c| c.lengths.len()).sum());
    for chunk in chunks {
        let mut rest = &chunk.nodes[..];
        for &length in &chunk.lengths {
            let (cut, after) = rest.split_at(length as usize);
            all.push(cut.to_vec());
            rest = after;
        }
    }
    all
}

/// Packs the cuts of points for vertices, each of which has the cut of one of the points.
pub(super) fn pack(
    cuts: Vec<Vec<u16>>,
    chunks: &[Chunk],
    of_vertex: impl Iterator<Item = u32>,
) -> Result<Packed, BakeError> {
    let texels: usize = cuts.iter().map(|c| c.len().div_ceil(NODES_PER_TEXEL)).sum();
    let limit = TEXTURE_WIDTH * TEXTURE_WIDTH;
    if texels > limit {
        return Err(BakeError::TooManyTexels { texels, limit });
    }
    let mut packed = PackedCuts::default();
    let offsets: Vec<u32> = cuts.iter().map(|cut| packed.push_cut(cut)).collect();
    of_vertex.for_each(|p| packed.push_vertex(offsets[p as usize]));
    let max_cut = cuts.iter().map(Vec::len).max().unwrap_or(0);
    Ok(Packed {
        cuts: packed,
        points: cuts.len(),
        nodes: cuts.iter().map(|c| c.len() as u64).sum(),
        max_cut,
        squared_error: chunks.iter().map(|c| c.squared_error).sum(),
        rays: chunks.iter().map(|c| c.rays).sum(),
        histogram: histogram(&cuts),
    })
}

fn histogram(cuts: &[Vec<u16>]) -> Vec<u64> {
    let longest = cuts.iter().map(Vec::len).max().unwrap_or(1);
    let mut histogram = vec![0; longest.ilog2() as usize + 1];
    cuts.iter().for_each(|cut| histogram[cut.len().ilog2() as usize] += 1);
    histogram
}

/// Coarsens all cuts by a common sigma, the smallest of a geometric series that fits the bytes.
pub(super) fn fit_budget(cuts: Vec<Vec<u16>>, height: u32, max_bytes: Option<u64>, sigma: f32) -> (Vec<Vec<u16>>, f32) {
    let bytes =
        |cuts: &[Vec<u16>]| cuts.iter().map(|c| (c.len().next_multiple_of(NODES_PER_TEXEL) * 2) as u64).sum::<u64>();
    let (mut fitted, mut coarser) = (cuts, sigma.max(0.25));
    let Some(budget) = max_bytes else { return (fitted, sigma) };
    if bytes(&fitted) <= budget {
        return (fitted, sigma);
    }
    const STEP: f32 = 1.05;
    while bytes(&fitted) > budget && fitted.iter().any(|c| c.len() > 1) {
        coarser *= STEP;
        fitted = fitted.par_iter().map(|cut| prune(height, coarser, cut)).collect();
    }
    (fitted, coarser)
}
