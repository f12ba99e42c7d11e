//! The merge at one pixel (paper, 4.2): three cuts, interpolated and multiplied by light and BRDF.
//!
//! `B = Σ |C| <l> <ρ> (w1 <v1> + w2 <v2> + w3 <v3>)` over the merged cut. The paper merges the stored cuts with an illumination
//! cut, and samples the BRDF once per node or, refined, more finely. Lit cuts know the light already and need no illumination
//! cut: where the pixel's lobe looks, the merge goes down into the stored cuts below them and on into the light tree.
//! Nodes without visibility are dropped before the BRDF is evaluated; the others are evaluated eight at a time. One
//! traversal serves the environment and the surface sources, see [`NodeField`]. Twin of `shaders/merge_pass.wgsl`: the
//! same terms in the same order.

use crate::shade::{
    node_field::NodeField,
    refine::Refinement,
    surface::{ReceiverX8, SurfacePoint},
};
use glam::{Mat3, Vec3};
use lapidary_core::{
    cut::{
        lit::LitCursor,
        merge::{Cursor, Interval, merge, merge_within},
        packed::{PackedCursor, PackedCuts},
    },
    simd::Vec3x8,
};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign};
use wide::f32x8;

/// Which cuts are merged, and how the BRDF is sampled on the nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrdfSampling {
    /// Stored cuts and the illumination cut; the BRDF once per node at its direction, as in the paper (Eq. 6).
    Once,
    /// The same cuts. Nodes too wide for the lobe are halved, and the lobe is filtered by the remaining width.
    Refine,
    /// Lit cuts, and where nodes are too wide for the lobe the stored cuts below them; then as [`Self::Refine`].
    #[default]
    Lit,
}

/// Work done for one pixel or many.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Nodes of merged cuts.
    pub merged_nodes: u64,
    /// BRDF evaluations.
    pub brdf_evaluations: u64,
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            merged_nodes: self.merged_nodes + other.merged_nodes,
            brdf_evaluations: self.brdf_evaluations + other.brdf_evaluations,
        }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Radius in radians above which a node is too wide for one cosine, where its cuts do not know the horizon.
const WIDEST: f32 = 0.35;

/// A node to evaluate.
#[derive(Clone, Copy)]
pub(crate) struct Term {
    /// Heap index.
    pub node: u32,
    /// Interpolated value of the vertices' cuts; zero in padding alone.
    pub visibility: f32,
    /// Whether it comes from lit cuts: then the value is a mean weighted by the light.
    pub is_lit: bool,
}

/// Eight terms of the sum, evaluated.
pub(crate) struct EightTerms<'t> {
    pub terms: &'t [Term],
    /// Unit directions to the nodes in world space.
    pub direction: Vec3x8,
    /// Mean radiance of the nodes.
    pub radiance: Vec3x8,
    /// BRDF times cosine at their directions.
    pub brdf_cos: Vec3x8,
    /// Visibility times number of leaves; zero where the direction is below the smooth normal's horizon.
    pub weight: f32x8,
}

impl EightTerms<'_> {
    /// Light reflected from the nodes, without the factor of a leaf's solid angle.
    #[inline(always)]
    pub fn reflected(&self) -> Vec3x8 {
        self.brdf_cos.scale(self.radiance) * self.weight
    }
}

/// The largest node of `root` that begins where `node` ends; 0 at the end of `root`.
fn next_node(node: u32, root: u32) -> u32 {
    let left = node >> node.trailing_ones();
    if left <= root { 0 } else { left + 1 }
}

/// Merges and evaluates; keeps its buffers between pixels.
pub struct Shader<'a, F> {
    field: F,
    cuts: &'a PackedCuts,
    height: u32,
    sampling: BrdfSampling,
    /// Whether the cuts know what is below the horizon of a surface: vertices do not see it.
    knows_horizon: bool,
    terms: Vec<Term>,
    /// Work done so far.
    pub work: Work,
}

impl<'a, F: NodeField> Shader<'a, F> {
    /// For visibility `cuts` over the tree of `field`.
    pub fn new(field: F, cuts: &'a PackedCuts, sampling: BrdfSampling) -> Self {
        let (height, work) = (field.height(), Work::default());
        Self { field, cuts, height, sampling, knows_horizon: true, terms: Vec::new(), work }
    }

    /// For `cuts` without any occlusion, not even by the surface itself.
    pub fn unoccluded(field: F, cuts: &'a PackedCuts) -> Self {
        Self { knows_horizon: false, ..Self::new(field, cuts, BrdfSampling::Refine) }
    }

    /// Reflected radiance toward the eye.
    pub fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        self.traverse(point, |_| (), |eight| sum = sum + eight.reflected());
        sum.reduce_add() * self.field.solid_angle()
    }

    /// Visits the terms that [`Self::shade`] sums, left to right, and before them the nodes of the merged cut without
    /// visible light.
    #[inline(always)]
    pub fn traverse(&mut self, point: &SurfacePoint, dark: impl FnMut(Interval), visit: impl FnMut(&EightTerms)) {
        let mut terms = std::mem::take(&mut self.terms);
        terms.clear();
        let merged = Merged::new(self, point);
        self.work.merged_nodes += match self.sampling {
            BrdfSampling::Lit => merged.lit(&mut terms, dark),
            BrdfSampling::Once | BrdfSampling::Refine => merged.stored(&mut terms, dark),
        };
        self.work.brdf_evaluations += terms.len() as u64;
        self.evaluate(point, &mut terms, visit);
        self.terms = terms;
    }

    /// Evaluates the terms, eight at a time.
    #[inline(always)]
    fn evaluate(&self, point: &SurfacePoint, terms: &mut Vec<Term>, mut visit: impl FnMut(&EightTerms)) {
        // Padding repeats the root without visibility.
        terms.resize(terms.len().next_multiple_of(8), Term { node: 1, visibility: 0.0, is_lit: false });
        let receiver = ReceiverX8::new(point);
        let brdf = point.brdf.as_brdf();
        for terms in terms.chunks_exact(8) {
            let index: [usize; 8] = std::array::from_fn(|i| terms[i].node as usize);
            let direction = self.field.directions(index, point.position);
            let inv_kappa = match self.sampling {
                BrdfSampling::Once => f32x8::ZERO,
                BrdfSampling::Refine | BrdfSampling::Lit => self.field.inv_kappas(index, point.position),
            };
            let size = |t: &Term| (1_u32 << (self.height - t.node.ilog2())) as f32;
            let weight = f32x8::new(std::array::from_fn(|i| terms[i].visibility * size(&terms[i])));
            let radiance = Vec3x8::from_array(index.map(|n| self.field.radiance(n)));
            let lights = match self.knows_horizon {
                true => receiver.lights(direction, inv_kappa),
                false => receiver.lights_at_centers(direction, inv_kappa),
            };
            let brdf_cos = brdf.reflect_x8(&lights, point.wo);
            visit(&EightTerms { terms, direction, radiance, brdf_cos, weight });
        }
    }
}

/// The nodes of the merged cut of one point.
struct Merged<'a, 'p, F> {
    field: F,
    cuts: &'a PackedCuts,
    height: u32,
    point: &'p SurfacePoint,
    local_from_world: Mat3,
    /// `None` where the BRDF is sampled once per node, and for BRDFs without a lobe.
    refinement: Option<Refinement>,
    knows_horizon: bool,
}

impl<'a, 'p, F: NodeField> Merged<'a, 'p, F> {
    fn new(shader: &Shader<'a, F>, point: &'p SurfacePoint) -> Self {
        let &Shader { field, cuts, height, sampling, knows_horizon, .. } = shader;
        let lobe = point.brdf.as_brdf().lobe().filter(|_| sampling != BrdfSampling::Once);
        let refinement = lobe.map(|lobe| Refinement::new(lobe, point.wo));
        let local_from_world = point.world_from_local.transpose();
        Self { field, cuts, height, point, local_from_world, refinement, knows_horizon }
    }

    fn leaves(&self) -> u32 {
        1 << self.height
    }

    /// Whether the BRDF needs more directions than that of the node.
    #[inline(always)]
    fn is_too_wide(&self, node: u32) -> bool {
        if self.refinement.is_none() && self.knows_horizon {
            return false;
        }
        let cone = self.field.cone(node as usize, self.point.position);
        let wi = self.local_from_world * cone.direction;
        let is_cut_off = !self.knows_horizon && cone.radius > WIDEST && wi.z > -cone.radius;
        let too_wide = |r: &Refinement| r.is_too_wide(wi, cone.radius, self.field.brightness(node as usize));
        is_cut_off || self.refinement.as_ref().is_some_and(too_wide)
    }

    /// Value of the three vertices' nodes, interpolated.
    #[inline(always)]
    fn interpolated(&self, codes: impl Fn(usize) -> u16) -> f32 {
        let value = |i: usize| self.point.weights[i] * self.field.cut_value(codes(i));
        value(0) + value(1) + value(2)
    }

    fn stored_cursors(&self) -> [PackedCursor<'a>; 3] {
        self.point.vertices.map(|v| PackedCursor::new(self.height, self.cuts.nodes_from(v)))
    }

    /// Merges the stored cuts with the illumination cut. Adds the terms of its nodes with visible light; the others go to
    /// `dark`. Returns the number of nodes.
    #[inline(always)]
    fn stored(&self, terms: &mut Vec<Term>, mut dark: impl FnMut(Interval)) -> u64 {
        let ([a, b, c], mut count) = (self.stored_cursors(), 0);
        let mut cursors = [a, b, c, PackedCursor::new(self.height, self.field.illumination_cut())];
        merge(self.leaves(), &mut cursors, |interval, cursors| {
            count += 1;
            let visibility = self.interpolated(|i| cursors[i].stored_value());
            if visibility > 0.0 {
                self.halve(Term { node: interval.heap_index(self.leaves()), visibility, is_lit: false }, terms);
            } else {
                dark(interval);
            }
        });
        count
    }

    /// Merges the lit cuts, and the stored ones below a node that is too wide. As [`Self::stored`] otherwise.
    #[inline(always)]
    fn lit(&self, terms: &mut Vec<Term>, mut dark: impl FnMut(Interval)) -> u64 {
        let lit = self.field.lit_cuts();
        let mut cursors = self.point.vertices.map(|v| LitCursor::new(self.height, &lit.of(self.cuts, v).nodes));
        let (mut stored, mut count) = (self.stored_cursors(), 0);
        merge(self.leaves(), &mut cursors, |interval, cursors| {
            count += 1;
            let visibility = self.interpolated(|i| cursors[i].code());
            let node = interval.heap_index(self.leaves());
            if !(visibility > 0.0) {
                dark(interval);
            } else if self.is_too_wide(node) {
                for (stored, cursor) in stored.iter_mut().zip(cursors) {
                    stored.seek(cursor.node().stored(), cursor.end() - cursor.size(), interval.first);
                }
                count += self.below(interval, &mut stored, terms, &mut dark) - 1;
            } else {
                terms.push(Term { node, visibility, is_lit: true });
            }
        });
        count
    }

    /// Merges the stored cuts of the leaves of one node.
    #[inline(always)]
    fn below(
        &self,
        within: Interval,
        stored: &mut [PackedCursor; 3],
        terms: &mut Vec<Term>,
        dark: &mut impl FnMut(Interval),
    ) -> u64 {
        let mut count = 0;
        merge_within(within, stored, |interval, cursors| {
            count += 1;
            let visibility = self.interpolated(|i| cursors[i].stored_value());
            if visibility > 0.0 {
                self.halve(Term { node: interval.heap_index(self.leaves()), visibility, is_lit: false }, terms);
            } else {
                dark(interval);
            }
        });
        count
    }

    /// Adds a node as it is, or halved where the BRDF needs it.
    #[inline(always)]
    fn halve(&self, root: Term, terms: &mut Vec<Term>) {
        let mut node = root.node;
        while node != 0 {
            while node < self.leaves() && self.is_too_wide(node) {
                node *= 2;
            }
            terms.push(Term { node, ..root });
            node = next_node(node, root.node);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stepping_over_leaves_visits_each_leaf_of_a_root_once() {
        let leaves = 16;
        for root in [1, 2, 3, 5, 7, 11, 15, 16, 31] {
            let first_leaf = |mut n: u32| {
                while n < leaves {
                    n *= 2;
                }
                n
            };
            let mut visited = Vec::new();
            let mut node = root;
            while node != 0 {
                node = first_leaf(node);
                visited.push(node);
                node = next_node(node, root);
            }
            let below = |n: u32| (0..5).any(|k| n >> k == root);
            assert_eq!(visited, (leaves..2 * leaves).filter(|&n| below(n)).collect::<Vec<_>>(), "{root}");
        }
        assert_eq!(next_node(4, 2), 5);
        assert_eq!(next_node(9, 2), 5); // the right leaf of the left half: on to the right half
    }
}
