//! Cuts as they are stored: 16 bits per node, eight nodes per texel.
//!
//! Layout of a node: bits 12 to 15 hold the depth (0 to 15), bits 0 to 11 the value as a fraction of 4095. Eight nodes
//! make one `Rgba32Uint` texel, two per component, the first in the low half. Each vertex's cut starts at a texel. A
//! cut ends with the node that ends at the last leaf; the rest of its last texel is zero. Texels are stored row by row
//! in a 2D texture [`TEXTURE_WIDTH`] wide. The paper stores 48 bits per node: index, leftleaf and value.

use super::{CutError, merge::Cursor, validate_depths};
use rayon::prelude::*;
use std::{borrow::Cow, sync::Arc};

/// Greatest stored value.
pub const VALUE_MAX: u16 = 4095;
/// Nodes in one texel.
pub const NODES_PER_TEXEL: usize = 8;
/// Bytes of one texel.
pub const TEXEL_BYTES: usize = 16;
/// Texels in one row of the texture: within WebGPU's default limits.
pub const TEXTURE_WIDTH: usize = 8192;

/// Packs a depth of at most 15 and a value from 0 to 1.
#[inline(always)]
pub fn pack_node(depth: u32, value: f32) -> u16 {
    (depth as u16) << 12 | quantize(value)
}

/// A value from 0 to 1 as a multiple of 1/4095, rounded to nearest.
#[inline(always)]
pub fn quantize(value: f32) -> u16 {
    (value * f32::from(VALUE_MAX) + 0.5) as u16
}

/// Depth of a packed node.
#[inline(always)]
pub fn depth(node: u16) -> u32 {
    u32::from(node >> 12)
}

/// Value of a packed node.
#[inline(always)]
pub fn value(node: u16) -> f32 {
    f32::from(node & VALUE_MAX) * (1.0 / VALUE_MAX as f32)
}

/// Number of nodes of the cut that starts at the front of `nodes`.
///
/// # Errors
/// Nodes that do not partition the leaves of a tree of `height`.
pub fn cut_len(height: u32, nodes: &[u16]) -> Result<usize, CutError> {
    validate_depths(height, nodes.iter().map(|&n| depth(n)))
}

/// A node that contains a packed node.
pub trait PackedNode: Copy {
    /// Depth and value.
    fn packed(self) -> u16;
}

impl PackedNode for u16 {
    #[inline(always)]
    fn packed(self) -> u16 {
        self
    }
}

/// Position of a [`PackedCursor`] in its cut.
#[derive(Clone, Copy, Debug)]
pub struct CutPlace {
    position: u32,
    end: u32,
}

impl CutPlace {
    /// Before the first node.
    pub const START: Self = Self { position: 0, end: 0 };
}

/// A position in a packed cut.
#[derive(Clone, Copy, Debug)]
pub struct PackedCursor<'a, N = u16> {
    nodes: &'a [N],
    height: u32,
    position: usize,
    end: u32,
}

impl<'a, N: PackedNode> PackedCursor<'a, N> {
    /// A cursor at the first of `nodes`, which begin with a valid cut of a tree of `height`.
    #[inline(always)]
    pub fn new(height: u32, nodes: &'a [N]) -> Self {
        Self { nodes, height, position: 0, end: 1 << (height - depth(nodes[0].packed())) }
    }

    /// The current position.
    #[inline(always)]
    pub fn place(&self) -> CutPlace {
        CutPlace { position: self.position as u32, end: self.end }
    }

    /// A cursor over the same cut at another place.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, place: CutPlace) -> Self {
        Self { position: place.position as usize, end: place.end, ..*self }
    }

    /// Moves forward to the node that contains `leaf`. The node at `position` begins at leaf `first`, at or before
    /// `leaf`. The cursor never steps back.
    #[inline(always)]
    pub fn seek(&mut self, position: usize, first: u32, leaf: u32) {
        if position > self.position {
            self.position = position;
            self.end = first + self.size();
        }
        while self.end <= leaf {
            self.advance();
        }
    }

    /// The current node.
    #[inline(always)]
    pub fn node(&self) -> N {
        self.nodes[self.position]
    }

    /// Value of the current node.
    #[inline(always)]
    pub fn value(&self) -> f32 {
        value(self.node().packed())
    }

    /// The current node's stored value, 0 to [`VALUE_MAX`].
    #[inline(always)]
    pub fn stored_value(&self) -> u16 {
        self.node().packed() & VALUE_MAX
    }

    /// Leaves below the current node.
    #[inline(always)]
    fn size(&self) -> u32 {
        1 << (self.height - depth(self.node().packed()))
    }

    /// First leaf of the current node.
    #[inline(always)]
    pub fn first(&self) -> u32 {
        self.end - self.size()
    }
}

impl<N: PackedNode> Cursor for PackedCursor<'_, N> {
    #[inline(always)]
    fn end(&self) -> u32 {
        self.end
    }

    #[inline(always)]
    fn advance(&mut self) {
        self.position += 1;
        self.end += self.size();
    }

    #[inline(always)]
    fn advance_from(&mut self, end: u32) {
        let steps = u32::from(self.end == end);
        self.position += steps as usize;
        self.end += steps * self.size();
    }
}

/// The visibility cuts of all vertices, packed. Copying them is cheap.
#[derive(Clone, Debug, Default)]
pub struct PackedCuts {
    /// Nodes of all cuts as stored; a multiple of eight. As `[u32; 4]` they are the texels.
    stored: Arc<Vec<u16>>,
    /// Nodes of the replacement cuts, which follow the stored ones; see [`Self::with`].
    others: Arc<Vec<u16>>,
    /// First texel of each vertex's cut. Vertices may share a cut.
    offsets: Arc<Vec<u32>>,
}

impl PartialEq for PackedCuts {
    fn eq(&self, other: &Self) -> bool {
        (self.nodes(), &self.offsets) == (other.nodes(), &other.offsets)
    }
}

impl PackedCuts {
    /// Creates cuts from stored arrays.
    ///
    /// # Errors
    /// The vertex whose cut is invalid for a tree of `height`, or starts outside the texels.
    pub fn from_parts(height: u32, nodes: Vec<u16>, offsets: Vec<u32>) -> Result<Self, (usize, CutError)> {
        let cuts = Self::unchecked(nodes, offsets);
        cuts.validate(height)?;
        Ok(cuts)
    }

    /// Creates cuts from stored arrays that [`Self::validate`] has yet to check.
    pub(crate) fn unchecked(nodes: Vec<u16>, offsets: Vec<u32>) -> Self {
        Self { stored: nodes.into(), others: Arc::default(), offsets: offsets.into() }
    }

    /// Checks all cuts.
    ///
    /// # Errors
    /// The vertex whose cut is invalid for a tree of `height`, or starts outside the texels.
    pub fn validate(&self, height: u32) -> Result<(), (usize, CutError)> {
        let check = |(vertex, &offset): (usize, &u32)| {
            cut_len(height, self.nodes_at(offset).unwrap_or(&[])).err().map(|error| (vertex, error))
        };
        self.offsets.par_iter().enumerate().find_map_first(check).map_or(Ok(()), Err)
    }

    /// Appends a cut and returns its first texel. Not allowed once cuts were replaced, because replacements follow the
    /// stored cuts.
    pub fn push_cut(&mut self, cut: &[u16]) -> u32 {
        assert!(self.others.is_empty(), "no cut was replaced before the last one is stored");
        append(Arc::make_mut(&mut self.stored), cut)
    }

    /// Appends a vertex whose cut starts at texel `offset`.
    pub fn push_vertex(&mut self, offset: u32) {
        Arc::make_mut(&mut self.offsets).push(offset);
    }

    /// The same stored cuts with replacements for some vertices.
    #[must_use]
    pub fn with(&self, others: impl IntoIterator<Item = (u32, Vec<u16>)>) -> Self {
        let (mut nodes, mut offsets) = ((*self.others).clone(), (*self.offsets).clone());
        let stored = self.stored_texels();
        for (vertex, cut) in others {
            offsets[vertex as usize] = stored + append(&mut nodes, &cut);
        }
        Self { stored: self.stored.clone(), others: nodes.into(), offsets: offsets.into() }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Whether there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.offsets.is_empty()
    }

    /// All nodes from the first node of a vertex's cut; the cut ends at the last leaf.
    #[inline(always)]
    pub fn nodes_from(&self, vertex: u32) -> &[u16] {
        self.nodes_at(self.offsets[vertex as usize]).expect("cuts begin within the texels")
    }

    #[inline(always)]
    fn nodes_at(&self, texel: u32) -> Option<&[u16]> {
        let node = texel as usize * NODES_PER_TEXEL;
        match node.checked_sub(self.stored.len()) {
            Some(node) if !self.others.is_empty() => self.others.get(node..),
            _ => self.stored.get(node..),
        }
    }

    /// The nodes of a vertex's cut alone.
    pub fn cut(&self, height: u32, vertex: u32) -> &[u16] {
        let nodes = self.nodes_from(vertex);
        let mut end = 0;
        let count = nodes.iter().position(|&n| {
            end += 1_u32 << (height - depth(n));
            end == 1 << height
        });
        &nodes[..count.map_or(nodes.len(), |c| c + 1)]
    }

    /// All nodes with padding; copied only if cuts were replaced.
    pub fn nodes(&self) -> Cow<'_, [u16]> {
        match self.parts() {
            [stored, []] => stored.into(),
            parts => parts.concat().into(),
        }
    }

    /// All nodes with padding: the stored ones, then the replacements.
    pub fn parts(&self) -> [&[u16]; 2] {
        [&self.stored, &self.others]
    }

    /// Whether both share the same stored cuts, not only equal ones.
    pub fn has_same_stored(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.stored, &other.stored)
    }

    /// First texel of each vertex.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// Texels of the stored cuts.
    pub fn stored_texels(&self) -> u32 {
        (self.stored.len() / NODES_PER_TEXEL) as u32
    }

    /// Whether there are replacements.
    pub fn has_replaced(&self) -> bool {
        !self.others.is_empty()
    }

    /// Whether the cut of a vertex is a replacement.
    pub fn is_replaced(&self, vertex: u32) -> bool {
        self.offsets[vertex as usize] as usize * NODES_PER_TEXEL >= self.stored.len()
    }

    /// First texels of the vertices' cuts that are replacements, or of those that are not, each once and in order.
    pub fn starts(&self, replaced: bool) -> Vec<u32> {
        let vertices = (0..self.len() as u32).filter(|&vertex| self.is_replaced(vertex) == replaced);
        let mut starts: Vec<u32> = vertices.map(|vertex| self.offsets[vertex as usize]).collect();
        starts.sort_unstable();
        starts.dedup();
        starts
    }
}

/// Appends a cut, padded to whole texels, and returns its first texel.
fn append(nodes: &mut Vec<u16>, cut: &[u16]) -> u32 {
    let texel = (nodes.len() / NODES_PER_TEXEL) as u32;
    nodes.extend_from_slice(cut);
    nodes.resize(nodes.len().next_multiple_of(NODES_PER_TEXEL), 0);
    texel
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_are_replaced_beside_the_stored_ones() {
        let (two, one) = ([pack_node(1, 0.0), pack_node(1, 1.0)], vec![pack_node(0, 0.5)]);
        let mut cuts = PackedCuts::default();
        for _ in 0..3 {
            let offset = cuts.push_cut(&two);
            cuts.push_vertex(offset);
        }
        let others = cuts.with([(1, one.clone()), (2, one.clone())]);
        assert!(others.has_same_stored(&cuts) && others != cuts && others.validate(4).is_ok());
        assert_eq!([0, 1, 2].map(|vertex| others.is_replaced(vertex)), [false, true, true]);
        assert_eq!([false, true].map(|replaced| others.starts(replaced)), [vec![0], vec![3, 4]]);
        assert_eq!([false, true].map(|replaced| cuts.starts(replaced)), [vec![0, 1, 2], vec![]]);
        assert_eq!([0, 1, 2].map(|vertex| others.cut(4, vertex)), [&two[..], &one, &one]);
        let whole = PackedCuts::from_parts(4, others.nodes().into_owned(), others.offsets().to_vec()).unwrap();
        assert!(whole == others && !whole.has_same_stored(&others));
        let again = others.with([(0, one.clone())]);
        assert_eq!([0, 1].map(|vertex| again.cut(4, vertex)), [&one[..], &one]);
    }

    #[test]
    fn nodes_round_trip_within_half_a_step() {
        for d in 0..16 {
            for i in 0..=1000 {
                let v = i as f32 / 1000.0;
                let node = pack_node(d, v);
                assert_eq!(depth(node), d);
                assert!((value(node) - v).abs() <= 0.5 / 4095.0 + 1e-7);
            }
        }
        assert_eq!((value(pack_node(0, 0.0)), value(pack_node(15, 1.0))), (0.0, 1.0));
    }

    #[test]
    fn cuts_start_at_texels_and_are_validated() {
        let two = [pack_node(1, 0.0), pack_node(1, 1.0)];
        let mut cuts = PackedCuts::default();
        for _ in 0..3 {
            let offset = cuts.push_cut(&two);
            cuts.push_vertex(offset);
        }
        assert_eq!(cuts.offsets(), &[0, 1, 2]);
        assert_eq!(cuts.nodes().len(), 24);
        assert_eq!(cuts.cut(4, 2), &two);
        let parts = |nodes: Vec<u16>, offsets| PackedCuts::from_parts(4, nodes, offsets);
        assert_eq!(parts(cuts.nodes().to_vec(), vec![0, 2]).unwrap().cut(4, 1), &two);
        assert_eq!(parts(cuts.nodes().to_vec(), vec![0, 3]).unwrap_err().0, 1);
        let fault = |depths: &[u32]| parts(depths.iter().map(|&d| pack_node(d, 0.0)).collect(), vec![0]).unwrap_err();
        assert_eq!(fault(&[1]), (0, CutError::Incomplete(8)));
        assert_eq!(fault(&[9; 8]), (0, CutError::Depth { node: 0, depth: 9, height: 4 }));
        assert_eq!(fault(&[2, 1, 2]), (0, CutError::Misplaced { node: 1, depth: 1, first: 4 }));
    }
}
