//! Chunks to packed cuts.

use crate::{
    bake::checkpoint::Chunk,
    errors::{BakeError, CutsOf},
};
use lapidary_core::cut::packed::{NODES_PER_TEXEL, PackedCuts, TEXTURE_WIDTH};

/// All cuts, and sums over their points.
pub struct Packed {
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
pub fn unbaked(points: usize) -> Chunk {
    Chunk { nodes: vec![0; points], lengths: vec![1; points], squared_errors: vec![0.0; points], rays: 0 }
}

/// The cut of each point.
pub fn concatenate(chunks: &[Chunk]) -> Vec<Vec<u16>> {
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
pub fn pack(
    cuts: Vec<Vec<u16>>,
    chunks: &[Chunk],
    of_vertex: impl Iterator<Item = u32>,
    of: CutsOf,
) -> Result<Packed, BakeError> {
    let texels: usize = cuts.iter().map(|c| c.len().div_ceil(NODES_PER_TEXEL)).sum();
    check_texels(texels, of)?;
    let mut packed = PackedCuts::default();
    let offsets: Vec<u32> = cuts.iter().map(|cut| packed.push_cut(cut)).collect();
    of_vertex.for_each(|p| packed.push_vertex(offsets[p as usize]));
    let max_cut = cuts.iter().map(Vec::len).max().unwrap_or(0);
    Ok(Packed {
        cuts: packed,
        points: cuts.len(),
        nodes: cuts.iter().map(|c| c.len() as u64).sum(),
        max_cut,
        squared_error: chunks.iter().flat_map(|c| &c.squared_errors).sum(),
        rays: chunks.iter().map(|c| c.rays).sum(),
        histogram: histogram(&cuts),
    })
}

fn check_texels(texels: usize, cuts: CutsOf) -> Result<(), BakeError> {
    let limit = TEXTURE_WIDTH * TEXTURE_WIDTH;
    if texels > limit { Err(BakeError::TooManyTexels { cuts, texels, limit }) } else { Ok(()) }
}

fn histogram(cuts: &[Vec<u16>]) -> Vec<u64> {
    let longest = cuts.iter().map(Vec::len).max().unwrap_or(1);
    let mut histogram = vec![0; longest.ilog2() as usize + 1];
    cuts.iter().for_each(|cut| histogram[cut.len().ilog2() as usize] += 1);
    histogram
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_holds_so_many_texels_and_no_more() {
        let limit = TEXTURE_WIDTH * TEXTURE_WIDTH;
        assert!(check_texels(limit, CutsOf::Sources).is_ok());
        let error = check_texels(limit + 1, CutsOf::Sources).unwrap_err();
        assert!(matches!(error, BakeError::TooManyTexels { cuts: CutsOf::Sources, .. }), "{error}");
    }
}
