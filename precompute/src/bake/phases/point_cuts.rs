//! The cuts of many points. Nodes of finished chunks stay in the checkpoint until needed, one chunk at a time: memory holds a
//! bake's cuts only once, when packed.

use crate::{
    bake::checkpoint::{Chunk, Kept},
    errors::BakeError,
};
use lapidary_core::cut::packed::{NODES_PER_TEXEL, TEXEL_BYTES};
use std::borrow::Cow;

/// Cuts of points, chunk by chunk.
pub struct PointCuts<'a> {
    /// Height of the tree below the cuts.
    height: u32,
    parts: Vec<Part<'a>>,
}

/// A chunk, in memory or in a checkpoint.
struct Part<'a> {
    lengths: Cow<'a, [u32]>,
    squared_errors: Cow<'a, [f64]>,
    rays: u64,
    nodes: Nodes<'a>,
}

enum Nodes<'a> {
    Here(Cow<'a, [u16]>),
    /// In a checkpoint, under the chunk's number.
    Kept(&'a Kept<'a>, usize),
}

/// One-node cuts of zero, for points that are not baked.
pub fn unbaked(points: usize) -> Chunk {
    Chunk { nodes: vec![0; points], lengths: vec![1; points], squared_errors: vec![0.0; points], rays: 0 }
}

impl<'a> PointCuts<'a> {
    /// Starts without points, over a tree of `height`.
    pub fn new(height: u32) -> Self {
        Self { height, parts: Vec::new() }
    }

    /// One-node cuts of zero, for an unbaked part.
    pub fn unbaked(points: usize) -> Self {
        let mut cuts = Self::new(0);
        cuts.push(unbaked(points));
        cuts
    }

    /// Appends a chunk.
    pub fn push(&mut self, chunk: Chunk) {
        let Chunk { nodes, lengths, squared_errors, rays } = chunk;
        let nodes = Nodes::Here(nodes.into());
        self.parts.push(Part { lengths: lengths.into(), squared_errors: squared_errors.into(), rays, nodes });
    }

    /// Appends a chunk by reference.
    pub fn push_borrowed(&mut self, Chunk { nodes, lengths, squared_errors, rays }: &'a Chunk) {
        let nodes = Nodes::Here(nodes.into());
        self.parts.push(Part { lengths: lengths.into(), squared_errors: squared_errors.into(), rays: *rays, nodes });
    }

    /// Appends a chunk stored in a checkpoint under `index`, without its nodes.
    pub fn push_kept(&mut self, Chunk { lengths, squared_errors, rays, .. }: Chunk, kept: &'a Kept<'a>, index: usize) {
        let nodes = Nodes::Kept(kept, index);
        self.parts.push(Part { lengths: lengths.into(), squared_errors: squared_errors.into(), rays, nodes });
    }

    /// Height of the tree below the cuts.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Number of nodes of each cut.
    fn lengths(&self) -> impl Iterator<Item = usize> {
        self.parts.iter().flat_map(|part| part.lengths.iter().map(|&length| length as usize))
    }

    /// Bytes in whole texels.
    pub fn bytes(&self) -> u64 {
        self.lengths().map(texel_bytes).sum()
    }

    /// Squared error of all cuts, summed in the order of the points.
    pub fn squared_error(&self) -> f64 {
        self.parts.iter().flat_map(|part| part.squared_errors.iter()).sum()
    }

    /// Rays traced for them.
    pub fn rays(&self) -> u64 {
        self.parts.iter().map(|part| part.rays).sum()
    }

    /// Calls `each` with the cuts of each chunk in order.
    ///
    /// # Errors
    /// A chunk that can no longer be read, or an error of `each`.
    pub fn each_chunk(&self, mut each: impl FnMut(&[&[u16]]) -> Result<(), BakeError>) -> Result<(), BakeError> {
        for part in &self.parts {
            let nodes = match &part.nodes {
                Nodes::Here(nodes) => Cow::Borrowed(&**nodes),
                Nodes::Kept(kept, index) => Cow::Owned(kept.again(*index, part.lengths.len(), self.height)?.nodes),
            };
            each(&part.cuts(&nodes))?;
        }
        Ok(())
    }
}

impl Part<'_> {
    /// Its nodes, cut by cut.
    fn cuts<'n>(&self, mut nodes: &'n [u16]) -> Vec<&'n [u16]> {
        let next = |&length: &u32| {
            let (cut, rest) = nodes.split_at(length as usize);
            nodes = rest;
            cut
        };
        self.lengths.iter().map(next).collect()
    }
}

/// Bytes of a cut in whole texels.
pub fn texel_bytes(nodes: usize) -> u64 {
    (nodes.div_ceil(NODES_PER_TEXEL) * TEXEL_BYTES) as u64
}
