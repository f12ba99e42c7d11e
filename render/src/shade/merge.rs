//! The merge at one pixel (paper, 4.2): three cuts, interpolated and multiplied by light and BRDF.
//!
//! `B = Σ |C| <l> <ρ> (w1 <v1> + w2 <v2> + w3 <v3>)` over the merged cut. The paper merges the stored cuts with an illumination
//! cut, and samples the BRDF once per node or, refined, more finely. Lit cuts know the light already and need no illumination
//! cut: where the pixel's lobe looks, the merge goes down into the stored cuts below them and on into the light tree.
//! Nodes without visibility are dropped before the BRDF is evaluated; the others are evaluated eight at a time. One
//! traversal serves the environment and the surface sources, see [`NodeField`]. Twin of `shaders/merge_pass.wgsl`: the
//! same terms in the same order.

use crate::shade::{
    mirror::{Mirror, MirroredMap},
    node_field::{EightLights, NodeField},
    refine::{Refinement, is_too_wide_for_a_cosine},
    surface::{ReceiverX8, SurfacePoint},
};
use glam::{Mat3, Vec3};
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor, NO_LOBE},
    cut::{
        merge::{Interval, merge, merge_within},
        packed::{PackedCursor, PackedCuts},
    },
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
};
use serde::{Deserialize, Serialize};
use std::{
    marker::PhantomData,
    ops::{Add, AddAssign},
};
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

/// A node to evaluate.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Term {
    /// Heap index.
    pub node: u32,
    /// Interpolated value of the vertices' cuts; zero in padding, and for nodes that only a [`Mirror`] asks for.
    pub visibility: f32,
    /// Whether it comes from lit cuts: then the value is a mean weighted by the light.
    pub is_lit: bool,
}

impl Term {
    /// What fills up eight: the root without visibility.
    const PADDING: Self = Self { node: 1, visibility: 0.0, is_lit: false };
}

/// Eight terms of the sum, evaluated.
pub(crate) struct EightTerms<'t, L = f32x8> {
    pub terms: &'t [Term],
    /// Unit directions to the nodes in world space.
    pub direction: Vec3x8<L>,
    /// The same in the local frame.
    pub wi: Vec3x8<L>,
    /// Mean radiance of the nodes.
    pub radiance: Vec3x8<L>,
    /// BRDF times cosine at their directions.
    pub brdf_cos: Vec3x8<L>,
    /// Visibility times number of leaves; zero where the direction is below the smooth normal's horizon.
    pub weight: L,
    /// Number of leaves; zero in padding.
    pub leaves: L,
}

impl<L: Lanes> EightTerms<'_, L> {
    /// Light reflected from the nodes, without the factor of a leaf's solid angle.
    #[inline(always)]
    pub fn reflected(&self) -> Vec3x8<L> {
        self.brdf_cos.scale(self.radiance) * self.weight
    }

    /// The same if all of the nodes were seen.
    #[inline(always)]
    fn unshadowed(&self) -> Vec3x8<L> {
        self.brdf_cos.scale(self.radiance) * self.leaves
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
    instructions: InstructionSet,
    /// Work done so far.
    pub work: Work,
}

impl<'a, F: NodeField> Shader<'a, F> {
    /// For visibility `cuts` over the tree of `field`.
    pub fn new(field: F, cuts: &'a PackedCuts, sampling: BrdfSampling) -> Self {
        let (height, instructions) = (field.height(), InstructionSet::widest());
        let (terms, work) = (Vec::new(), Work::default());
        Self { field, cuts, height, sampling, knows_horizon: true, terms, instructions, work }
    }

    /// For `cuts` without any occlusion, not even by the surface itself.
    pub fn unoccluded(field: F, cuts: &'a PackedCuts) -> Self {
        Self { knows_horizon: false, ..Self::new(field, cuts, BrdfSampling::Refine) }
    }

    /// Reflected radiance toward the eye.
    pub fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        self.instructions.run(Shade { shader: self, point })
    }

    /// The sharp lobes of a point that read the map of the light, if it has one.
    fn mirror(&self, point: &SurfacePoint) -> Option<(Mirror, &'a MirroredMap)>
    where
        F: 'a,
    {
        let map = self.field.mirrored().filter(|_| self.sampling != BrdfSampling::Once)?;
        Some((Mirror::at(point, self.field.solid_angle())?, map))
    }

    /// Visits the terms that are summed without a [`Mirror`], left to right, and before them the nodes of the merged cut
    /// without visible light.
    #[inline(always)]
    pub fn traverse<L: Lanes>(
        &mut self,
        point: &SurfacePoint,
        dark: impl FnMut(Interval),
        visit: impl FnMut(&EightTerms<L>),
    ) {
        self.traverse_with(point, None, dark, visit);
    }

    /// As [`Self::traverse`], also with the nodes without visible light that reach into the window of a mirror.
    #[inline(always)]
    fn traverse_with<L: Lanes>(
        &mut self,
        point: &SurfacePoint,
        mirror: Option<&Mirror>,
        dark: impl FnMut(Interval),
        visit: impl FnMut(&EightTerms<L>),
    ) {
        let mut terms = std::mem::take(&mut self.terms);
        terms.clear();
        let merged = Merged::new(self, point, mirror);
        self.work.merged_nodes += match self.sampling {
            BrdfSampling::Lit => merged.lit(&mut terms, dark),
            BrdfSampling::Once | BrdfSampling::Refine => merged.stored(&mut terms, dark),
        };
        self.work.brdf_evaluations += terms.len() as u64;
        self.evaluate(point, mirror, &mut terms, visit);
        self.terms = terms;
    }

    /// Evaluates the terms, eight at a time.
    #[inline(always)]
    fn evaluate<L: Lanes>(
        &self,
        point: &SurfacePoint,
        mirror: Option<&Mirror>,
        terms: &mut Vec<Term>,
        visit: impl FnMut(&EightTerms<L>),
    ) {
        terms.resize(terms.len().next_multiple_of(8), Term::PADDING);
        let terms = terms.as_chunks::<8>().0;
        point.brdf.visit(Evaluate { shader: self, point, mirror, terms, visit, lanes: PhantomData::<L> });
    }

    #[inline(always)]
    fn evaluate_with<L: Lanes>(
        &self,
        brdf: &impl Brdf,
        point: &SurfacePoint,
        mirror: Option<&Mirror>,
        terms: &[[Term; 8]],
        mut visit: impl FnMut(&EightTerms<L>),
    ) {
        let receiver = ReceiverX8::<L>::new(point);
        let spread = self.sampling != BrdfSampling::Once;
        for terms in terms {
            let mut nodes = [0; 8];
            for (node, term) in nodes.iter_mut().zip(terms) {
                *node = term.node as usize;
            }
            let EightLights { direction, inv_kappa, radiance } = self.field.light::<L>(nodes, point.position, spread);
            let mut lights = match self.knows_horizon {
                true => receiver.lights(direction, inv_kappa),
                false => receiver.lights_at_centers(direction, inv_kappa),
            };
            if let Some(mirror) = mirror {
                lights.spread.inv_kappa = mirror.spread(lights.wi, lights.spread.inv_kappa);
            }
            let (brdf_cos, [weight, leaves]) = (brdf.reflect(&lights, point.wo), self.weights(terms));
            visit(&EightTerms { terms, direction, wi: lights.wi, radiance, brdf_cos, weight, leaves });
        }
    }

    /// Visibility times number of leaves, and number of leaves.
    #[inline(always)]
    fn weights<L: Lanes>(&self, terms: &[Term; 8]) -> [L; 2] {
        let (mut weights, mut leaves) = ([0.0; 8], [0.0; 8]);
        for ((weight, leaves), term) in weights.iter_mut().zip(&mut leaves).zip(terms) {
            let below = (1_u32 << (self.height - term.node.ilog2())) as f32;
            *weight = term.visibility * below;
            *leaves = if *term == Term::PADDING { 0.0 } else { below };
        }
        [L::new(weights), L::new(leaves)]
    }
}

/// [`Shader::evaluate`] for each model.
struct Evaluate<'s, 'a, 't, F, L, V> {
    shader: &'s Shader<'a, F>,
    point: &'s SurfacePoint,
    mirror: Option<&'s Mirror>,
    terms: &'t [[Term; 8]],
    visit: V,
    lanes: PhantomData<L>,
}

impl<F: NodeField, L: Lanes, V: FnMut(&EightTerms<L>)> BrdfVisitor for Evaluate<'_, '_, '_, F, L, V> {
    #[inline(always)]
    fn visit(self, brdf: &impl Brdf) {
        self.shader.evaluate_with::<L>(brdf, self.point, self.mirror, self.terms, self.visit);
    }
}

/// [`Shader::shade`] in the instructions of the machine.
struct Shade<'s, 'a, 'p, F> {
    shader: &'s mut Shader<'a, F>,
    point: &'p SurfacePoint,
}

impl<F: NodeField> Kernel for Shade<'_, '_, '_, F> {
    type Output = Vec3;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec3 {
        let Self { shader, point } = self;
        let mirror = shader.mirror(point);
        let mut sums = [Vec3x8::<L>::splat(Vec3::ZERO); 3];
        let [reflected, seen, all] = &mut sums;
        shader.traverse_with::<L>(
            point,
            mirror.as_ref().map(|(mirror, _)| mirror),
            |_| (),
            #[inline(always)]
            |eight| {
                *reflected = *reflected + eight.reflected();
                if let Some((mirror, _)) = &mirror {
                    let window = mirror.window(eight.wi);
                    *seen = *seen + eight.reflected() * window;
                    *all = *all + eight.unshadowed() * window;
                }
            },
        );
        let per_leaf = shader.field.solid_angle();
        let [reflected, seen, all] = [reflected, seen, all].map(|sum| sum.reduce_add() * per_leaf);
        let Some((mirror, map)) = mirror else { return reflected };
        mirror.sharpened(
            reflected,
            seen,
            all,
            #[inline(always)]
            || mirror.unshadowed::<L>(point, map),
        )
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
    /// Whether nodes are halved where one direction is too few.
    is_refined: bool,
    /// What also needs nodes without visible light.
    mirror: Option<&'p Mirror>,
}

impl<'a, 'p, F: NodeField> Merged<'a, 'p, F> {
    fn new(shader: &Shader<'a, F>, point: &'p SurfacePoint, mirror: Option<&'p Mirror>) -> Self {
        let &Shader { field, cuts, height, sampling, .. } = shader;
        let lobes = point.lobes();
        let refinement =
            (sampling != BrdfSampling::Once && lobes[0] != NO_LOBE).then(|| Refinement::new(lobes, point.wo));
        let local_from_world = point.world_from_local.transpose();
        let is_refined = sampling != BrdfSampling::Once;
        Self { field, cuts, height, point, local_from_world, refinement, is_refined, mirror }
    }

    fn leaves(&self) -> u32 {
        1 << self.height
    }

    /// Whether the lobe needs more directions than that of the node.
    #[inline(always)]
    fn shows_in_lobe(&self, node: u32) -> bool {
        let Some(refinement) = &self.refinement else { return false };
        let cone = self.field.cone(node as usize, self.point.position);
        refinement.is_too_wide(self.local_from_world * cone.direction, cone.radius, cone.brightness)
    }

    /// Whether the BRDF needs more directions than that of the node.
    #[inline(always)]
    fn is_too_wide(&self, node: u32) -> bool {
        if !self.is_refined {
            return false;
        }
        let cone = self.field.cone(node as usize, self.point.position);
        let wi = self.local_from_world * cone.direction;
        let too_wide = |r: &Refinement| r.is_too_wide(wi, cone.radius, cone.brightness);
        is_too_wide_for_a_cosine(wi, cone.radius) || self.refinement.as_ref().is_some_and(too_wide)
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
        merge(
            self.leaves(),
            &mut cursors,
            #[inline(always)]
            |interval, cursors| {
                count += 1;
                self.add_stored(interval, cursors, terms, &mut dark);
            },
        );
        count
    }

    /// Adds the terms of a node of the merged stored cuts, or hands it to `dark`. The first three of `cursors` are those of
    /// the vertices.
    #[inline(always)]
    fn add_stored(
        &self,
        interval: Interval,
        cursors: &[PackedCursor],
        terms: &mut Vec<Term>,
        dark: &mut impl FnMut(Interval),
    ) {
        let visibility = self.interpolated(|i| cursors[i].stored_value());
        let node = interval.heap_index(self.leaves());
        if visibility > 0.0 {
            self.halve(Term { node, visibility, is_lit: false }, terms);
        } else {
            dark(interval);
            self.add_dark(node, terms);
        }
    }

    /// Adds a node without visible light if it reaches into the window of a mirror.
    #[inline(always)]
    fn add_dark(&self, node: u32, terms: &mut Vec<Term>) {
        let Some(mirror) = self.mirror else { return };
        let cone = self.field.cone(node as usize, self.point.position);
        if mirror.overlaps(self.local_from_world * cone.direction, cone.radius) {
            self.halve(Term { node, visibility: 0.0, is_lit: false }, terms);
        }
    }

    /// Merges the lit cuts, and the stored ones below a node that the lobe shows. As [`Self::stored`] otherwise.
    #[inline(always)]
    fn lit(&self, terms: &mut Vec<Term>, mut dark: impl FnMut(Interval)) -> u64 {
        let lit = self.field.lit_cuts();
        let mut cursors = self.point.vertices.map(|v| PackedCursor::new(self.height, lit.of(self.cuts, v)));
        let (mut stored, mut count) = (self.stored_cursors(), 0);
        merge(
            self.leaves(),
            &mut cursors,
            #[inline(always)]
            |interval, cursors| {
                count += 1;
                let visibility = self.interpolated(|i| cursors[i].stored_value());
                let node = interval.heap_index(self.leaves());
                if !(visibility > 0.0) {
                    dark(interval);
                    self.add_dark(node, terms);
                } else if self.shows_in_lobe(node) {
                    for (stored, cursor) in stored.iter_mut().zip(cursors) {
                        stored.seek(cursor.node().stored(), cursor.first(), interval.first);
                    }
                    count += self.below(interval, &mut stored, terms, &mut dark) - 1;
                } else {
                    self.halve(Term { node, visibility, is_lit: true }, terms);
                }
            },
        );
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
        merge_within(
            within,
            stored,
            #[inline(always)]
            |interval, cursors| {
                count += 1;
                self.add_stored(interval, cursors, terms, dark);
            },
        );
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
mod tests;
