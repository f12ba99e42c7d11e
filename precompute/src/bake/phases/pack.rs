//! Packs cuts of points for vertices.

use super::point_cuts::PointCuts;
use crate::errors::{BakeError, CutsOf};
use lapidary_core::cut::packed::{NODES_PER_TEXEL, PackedCuts, TEXTURE_WIDTH};
use rayon::prelude::*;

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

/// Coarsens a cut.
pub type Coarsening<'a> = &'a (dyn Fn(&[u16]) -> Vec<u16> + Sync);

/// Packs the cuts of points for vertices, each of which has the cut of one point. `coarsened` coarsens the stored cuts; without it
/// they stay unchanged.
pub fn pack(
    cuts: &PointCuts,
    coarsened: Option<Coarsening>,
    of_vertex: impl Iterator<Item = u32>,
    of: CutsOf,
) -> Result<Packed, BakeError> {
    let mut packed = PackedCuts::default();
    let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
    let mut push = |cut: &[u16]| {
        lengths.push(cut.len());
        offsets.push(packed.push_cut(cut));
    };
    cuts.each_chunk(|chunk| match coarsened {
        Some(coarsened) => {
            let fitted: Vec<Vec<u16>> = chunk.par_iter().map(|cut| coarsened(cut)).collect();
            fitted.iter().for_each(|cut| push(cut));
            Ok(())
        }
        None => {
            chunk.iter().for_each(|cut| push(cut));
            Ok(())
        }
    })?;
    check_texels(packed.nodes().len() / NODES_PER_TEXEL, of)?;
    of_vertex.for_each(|p| packed.push_vertex(offsets[p as usize]));
    Ok(Packed {
        cuts: packed,
        points: lengths.len(),
        nodes: lengths.iter().map(|&length| length as u64).sum(),
        max_cut: lengths.iter().copied().max().unwrap_or(0),
        squared_error: cuts.squared_error(),
        rays: cuts.rays(),
        histogram: histogram(&lengths),
    })
}

fn check_texels(texels: usize, cuts: CutsOf) -> Result<(), BakeError> {
    let limit = TEXTURE_WIDTH * TEXTURE_WIDTH;
    if texels > limit { Err(BakeError::TooManyTexels { cuts, texels, limit }) } else { Ok(()) }
}

fn histogram(lengths: &[usize]) -> Vec<u64> {
    let longest = lengths.iter().copied().max().unwrap_or(1);
    let mut histogram = vec![0; longest.ilog2() as usize + 1];
    lengths.iter().for_each(|length| histogram[length.ilog2() as usize] += 1);
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
