//! Lit cuts: vertices' cuts, coarsened under the current light.
//!
//! A stored cut resolves visibility everywhere, because it was selected before any light was known. Most of its nodes
//! cover directions that send little light. Two siblings become one node while the light that this moves between its
//! parts stays below a share `tau` of the vertex's whole light: `Σ |el v - el v'| <= tau Σ el v`. Here `el` is the
//! luminance of a stored node times its leaves, `v` its value and `v'` the mean of the values weighted by `el`. A node
//! sends the light of its parts, so a BRDF constant over it sees no difference. Where the BRDF varies, the merge
//! continues in the stored nodes, whose position each node keeps.

use super::{
    packed::{PackedCuts, PackedNode, VALUE_MAX, depth, quantize, value},
    solid_angles::{solid_angle_code, solid_angles},
};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// Default largest share of a vertex's light that a node of its lit cut may move.
pub const DEFAULT_TAU: f32 = 0.003;

/// Meaning of the 12-bit codes of a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutValues {
    /// Visibility, as a fraction of [`VALUE_MAX`].
    Visibility,
    /// Solid angles in steradians, see [`solid_angle_code`].
    SolidAngles,
}

impl CutValues {
    /// The value of a packed node.
    #[inline(always)]
    fn of(self, node: u16) -> f32 {
        match self {
            Self::Visibility => value(node),
            Self::SolidAngles => solid_angles()[usize::from(node & VALUE_MAX)],
        }
    }

    fn code(self, value: f32) -> u16 {
        match self {
            Self::Visibility => quantize(value),
            Self::SolidAngles => solid_angle_code(value),
        }
    }
}

/// A node of a lit cut: the packed node in the low half, in the high half the position in the stored cut of the first
/// node below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LitNode(u32);

impl PackedNode for LitNode {
    #[inline(always)]
    fn packed(self) -> u16 {
        self.0 as u16
    }
}

impl LitNode {
    /// Position in the vertex's stored cut of the first node below it.
    #[inline(always)]
    pub fn stored(self) -> usize {
        (self.0 >> 16) as usize
    }
}

/// A node under construction.
#[derive(Clone, Copy)]
struct Part {
    depth: u32,
    /// Position of its first stored node.
    stored: usize,
    code: u16,
    value: f32,
    /// Luminance times leaves.
    light: f32,
    /// Upper bound of the light that its value moves between the stored nodes below it.
    moved: f32,
}

impl Part {
    /// Joins two siblings into one node.
    fn joined(values: CutValues, left: &Self, right: &Self) -> Self {
        let light = left.light + right.light;
        let share = if light > 0.0 { right.light / light } else { 0.5 };
        let value = left.value + (right.value - left.value) * share;
        let moves = |part: &Self| part.moved + part.light * (part.value - value).abs();
        let code = if left.code == right.code { left.code } else { values.code(value) };
        Self { depth: left.depth - 1, stored: left.stored, code, value, light, moved: moves(left) + moves(right) }
    }
}

/// Lit cuts of all vertices under one light. Each is built on first use, so the light may change many times before a
/// vertex is seen.
#[derive(Clone, Debug)]
pub struct LitCuts {
    values: CutValues,
    /// Luminance times leaves of each node, by heap index.
    light: Vec<f32>,
    tau: f32,
    /// One per vertex, once their number is known.
    cuts: OnceLock<Vec<OnceLock<Arc<[LitNode]>>>>,
}

impl LitCuts {
    /// Lit cuts of `values` over a tree whose nodes have mean `luminance` by heap index.
    pub fn new(values: CutValues, luminance: impl ExactSizeIterator<Item = f32>, tau: f32) -> Self {
        let leaves = luminance.len() / 2;
        let size = |node: usize| (leaves >> node.max(1).ilog2()) as f32;
        let light = luminance.enumerate().map(|(node, l)| l * size(node)).collect();
        Self { values, light, tau, cuts: OnceLock::new() }
    }

    /// Largest share of a vertex's light that a node moves between its parts.
    pub fn tau(&self) -> f32 {
        self.tau
    }

    /// The same light with another `tau`.
    pub fn with_tau(self, tau: f32) -> Self {
        if tau == self.tau { self } else { Self { tau, cuts: OnceLock::new(), ..self } }
    }

    /// The same light for other cuts. Lit cuts of those that are not replaced are kept.
    #[must_use]
    pub fn with_replaced(&self, others: &PackedCuts) -> Self {
        let cuts = OnceLock::new();
        if let Some(made) = self.cuts.get() {
            let kept = (0..).zip(made).map(|(vertex, cut)| match others.is_replaced(vertex) {
                true => OnceLock::new(),
                false => cut.clone(),
            });
            cuts.get_or_init(|| kept.collect());
        }
        Self { cuts, light: self.light.clone(), ..*self }
    }

    /// The lit cut, left to right, of one vertex of `stored`. Every call must pass the same cuts.
    #[inline(always)]
    pub fn of(&self, stored: &PackedCuts, vertex: u32) -> &[LitNode] {
        let cuts = self.cuts.get_or_init(|| std::iter::repeat_with(OnceLock::new).take(stored.len()).collect());
        cuts[vertex as usize].get_or_init(|| self.cut(stored.nodes_from(vertex)).into())
    }

    /// Builds the lit cuts of all vertices.
    pub fn make_all(&self, stored: &PackedCuts) {
        (0..stored.len() as u32).into_par_iter().for_each(|vertex| {
            self.of(stored, vertex);
        });
    }

    fn height(&self) -> u32 {
        (self.light.len() / 2).ilog2()
    }

    /// The lit cut of the stored cut at the front of `nodes`.
    pub fn cut(&self, nodes: &[u16]) -> Box<[LitNode]> {
        let whole: f32 = self.parts(nodes).map(|part| part.light * part.value).sum();
        let mut parts: Vec<Part> = Vec::with_capacity(64);
        let mut end = 0;
        for part in self.parts(nodes) {
            end += 1_u32 << (self.height() - part.depth);
            parts.push(part);
            while let Some(joined) = self.joins(&parts, end, whole) {
                parts.pop();
                let last = parts.len() - 1;
                parts[last] = joined;
            }
        }
        let pack = |p: &Part| LitNode((p.stored as u32) << 16 | p.depth << 12 | u32::from(p.code));
        parts.iter().map(pack).collect()
    }

    /// The nodes of the stored cut at the front of `nodes`.
    fn parts<'a>(&'a self, nodes: &'a [u16]) -> impl Iterator<Item = Part> + 'a {
        let (leaves, height) = (self.light.len() as u32 / 2, self.height());
        let mut first = 0;
        nodes.iter().enumerate().map_while(move |(stored, &node)| {
            if first == leaves {
                return None;
            }
            let (depth, code, value) = (depth(node), node & VALUE_MAX, self.values.of(node));
            let light = self.light[((leaves + first) >> (height - depth)) as usize];
            first += 1 << (height - depth);
            Some(Part { depth, stored, code, value, light, moved: 0.0 })
        })
    }

    /// Joins the last two of `parts`, which end at leaf `end`, if they are siblings and joining them moves little light.
    fn joins(&self, parts: &[Part], end: u32, whole: f32) -> Option<Part> {
        let [.., left, right] = parts else { return None };
        let size = 1_u32 << (self.height() - right.depth);
        if self.tau <= 0.0 || left.depth != right.depth || !end.is_multiple_of(2 * size) {
            return None;
        }
        let joined = Part::joined(self.values, left, right);
        (joined.moved <= self.tau * whole).then_some(joined)
    }
}

#[cfg(test)]
mod tests;
