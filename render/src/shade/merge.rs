//! The merge at one pixel (paper, 4.2): three visibility cuts, interpolated and multiplied by light and BRDF.
//!
//! `B = Σ |C| <l> <ρ> (w1 <v1> + w2 <v2> + w3 <v3>)` over the merged cut. Nodes without visibility are dropped before
//! the BRDF is evaluated; the others are evaluated eight at a time. One traversal serves the environment and the
//! surface sources, see [`NodeField`]. Twin of `shaders/merge_pass.wgsl`: the same terms in the same order.

use crate::shade::{
    node_field::NodeField,
    refine::Refinement,
    surface::{ReceiverX8, SurfacePoint},
};
use glam::Vec3;
use lapidary_core::{
    brdf::{Brdf, SurfaceBrdf},
    cut::{
        merge::{Interval, merge},
        packed::{PackedCursor, PackedCuts},
    },
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign};
use wide::f32x8;

/// How the BRDF is sampled on the nodes of the merged cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrdfSampling {
    /// Once per node at its direction, as in the paper (Eq. 6).
    Once,
    /// Nodes too wide for the lobe are halved, and the lobe is filtered by the remaining width.
    #[default]
    Refine,
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
#[derive(Clone, Copy)]
pub(crate) struct Term {
    /// Heap index.
    pub node: u32,
    /// Interpolated value of the vertices' cuts; zero in padding alone.
    pub visibility: f32,
}

/// Eight terms of the sum, evaluated.
pub(crate) struct EightTerms<'t, L = f32x8> {
    pub terms: &'t [Term],
    /// Unit directions to the nodes in world space.
    pub direction: Vec3x8<L>,
    /// Mean radiance of the nodes.
    pub radiance: Vec3x8<L>,
    /// BRDF times cosine at their directions.
    pub brdf_cos: Vec3x8<L>,
    /// Visibility times number of leaves; zero where the direction is below the smooth normal's horizon.
    pub weight: L,
}

impl<L: Lanes> EightTerms<'_, L> {
    /// Light reflected from the nodes, without the factor of a leaf's solid angle.
    #[inline(always)]
    pub fn reflected(&self) -> Vec3x8<L> {
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
    merged: Vec<Term>,
    terms: Vec<Term>,
    instructions: InstructionSet,
    /// Work done so far.
    pub work: Work,
}

impl<'a, F: NodeField> Shader<'a, F> {
    /// For visibility `cuts` over the tree of `field`.
    pub fn new(field: F, cuts: &'a PackedCuts, sampling: BrdfSampling) -> Self {
        let (height, work) = (field.height(), Work::default());
        let instructions = InstructionSet::widest();
        Self { field, cuts, height, sampling, merged: Vec::new(), terms: Vec::new(), instructions, work }
    }

    /// Reflected radiance toward the eye.
    pub fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        self.instructions.run(Shade { shader: self, point })
    }

    /// Visits the terms that [`Self::shade`] sums, left to right, and before them the nodes of the merged cut without
    /// visible light.
    #[inline(always)]
    pub fn traverse<L: Lanes>(
        &mut self,
        point: &SurfacePoint,
        dark: impl FnMut(Interval),
        visit: impl FnMut(&EightTerms<L>),
    ) {
        self.merge_cuts(point, dark);
        match self.sampling {
            BrdfSampling::Once => std::mem::swap(&mut self.merged, &mut self.terms),
            BrdfSampling::Refine => self.refine(point),
        }
        self.work.brdf_evaluations += self.terms.len() as u64;
        self.evaluate(point, visit);
    }

    /// Fills `merged` with the nodes of the merged cut that have visible light; the others go to `dark`.
    #[inline(always)]
    fn merge_cuts(&mut self, point: &SurfacePoint, mut dark: impl FnMut(Interval)) {
        let height = self.height;
        let leaves = 1_u32 << height;
        let visibility = |v: u32| PackedCursor::new(height, self.cuts.nodes_from(v));
        let [a, b, c] = point.vertices;
        let mut cursors =
            [visibility(a), visibility(b), visibility(c), PackedCursor::new(height, self.field.illumination_cut())];
        let weights = point.weights;
        let (merged, mut count) = (&mut self.merged, 0);
        merged.clear();
        merge(leaves, &mut cursors, |interval, cursors| {
            count += 1;
            let value = |i: usize| weights[i] * self.field.cut_value(cursors[i].stored_value());
            let visibility = value(0) + value(1) + value(2);
            if visibility > 0.0 {
                merged.push(Term { node: interval.heap_index(leaves), visibility });
            } else {
                dark(interval);
            }
        });
        self.work.merged_nodes += count;
    }

    /// Fills `terms` with the nodes of `merged`, halved where the BRDF needs it.
    fn refine(&mut self, point: &SurfacePoint) {
        let leaves = 1_u32 << self.height;
        let refinement = Refinement::new(point.brdf.as_brdf().lobe(), point.wo);
        let local_from_world = point.world_from_local.transpose();
        let wants_halves = |node: u32| {
            let cone = self.field.cone(node as usize, point.position);
            refinement.is_too_wide(local_from_world * cone.direction, cone.radius, || cone.tan_half_radius)
        };
        self.terms.clear();
        for &root in &self.merged {
            let mut node = root.node;
            while node != 0 {
                while node < leaves && wants_halves(node) {
                    node *= 2;
                }
                self.terms.push(Term { node, ..root });
                node = next_node(node, root.node);
            }
        }
    }

    /// Evaluates the terms, eight at a time.
    #[inline(always)]
    fn evaluate<L: Lanes>(&mut self, point: &SurfacePoint, visit: impl FnMut(&EightTerms<L>)) {
        // Padding repeats the root without visibility.
        self.terms.resize(self.terms.len().next_multiple_of(8), Term { node: 1, visibility: 0.0 });
        match &point.brdf {
            SurfaceBrdf::Lambert(brdf) => self.evaluate_with(brdf, point, visit),
            SurfaceBrdf::Ggx(brdf) => self.evaluate_with(brdf, point, visit),
            SurfaceBrdf::Ward(brdf) => self.evaluate_with(brdf, point, visit),
        }
    }

    #[inline(always)]
    fn evaluate_with<L: Lanes>(&self, brdf: &impl Brdf, point: &SurfacePoint, mut visit: impl FnMut(&EightTerms<L>)) {
        let receiver = ReceiverX8::<L>::new(point);
        let spread = self.sampling == BrdfSampling::Refine;
        for terms in self.terms.as_chunks::<8>().0 {
            let mut nodes = [0; 8];
            for (node, term) in nodes.iter_mut().zip(terms) {
                *node = term.node as usize;
            }
            let light = self.field.light::<L>(nodes, point.position, spread);
            let weight = receiver.receives(light.direction) & self.weight(terms);
            let brdf_cos = brdf.brdf_cos_lanes(receiver.local(light.direction), point.wo, light.inv_kappa);
            visit(&EightTerms { terms, direction: light.direction, radiance: light.radiance, brdf_cos, weight });
        }
    }

    /// Visibility times number of leaves.
    #[inline(always)]
    fn weight<L: Lanes>(&self, terms: &[Term; 8]) -> L {
        let mut weight = [0.0; 8];
        for (weight, term) in weight.iter_mut().zip(terms) {
            *weight = term.visibility * (1_u32 << (self.height - term.node.ilog2())) as f32;
        }
        L::new(weight)
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
        let mut sum = Vec3x8::<L>::splat(Vec3::ZERO);
        self.shader.traverse::<L>(
            self.point,
            |_| (),
            #[inline(always)]
            |eight| sum = sum + eight.reflected(),
        );
        sum.reduce_add() * self.shader.field.solid_angle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        renderer::Renderer,
        test_scenes::{dataset, from_the_side, glossy, illumination, mesh, surface_at},
    };
    use lapidary_core::material::BrdfModel;

    /// The bits of one point in each instruction set, under each model and sampling.
    fn bits_in_each_set<F: NodeField>(field: F, cuts: &PackedCuts, point: &SurfacePoint) -> Vec<Vec<[u32; 3]>> {
        let shaded = |instructions: InstructionSet| {
            let mut bits = Vec::new();
            for model in [BrdfModel::Lambert, BrdfModel::Ggx, BrdfModel::Ward] {
                let point = SurfacePoint { brdf: SurfaceBrdf::new(model, point.parameters), ..point.clone() };
                for sampling in [BrdfSampling::Once, BrdfSampling::Refine] {
                    let mut shader = Shader { instructions, ..Shader::new(field, cuts, sampling) };
                    bits.push(shader.shade(&point).to_array().map(f32::to_bits));
                }
            }
            bits
        };
        InstructionSet::available().map(shaded).collect()
    }

    #[test]
    fn all_instruction_sets_shade_a_point_to_the_same_bits() {
        let renderer = Renderer::new(dataset(mesh(16, true), glossy(0.4)));
        let light = illumination([64, 32], |x, y| Vec3::new(0.3, 0.2, if x > 40 && y < 10 { 30.0 } else { 0.1 }));
        let lighting = renderer.lighting(&light, 64);
        let point = surface_at(&renderer, &from_the_side(24));
        let far = bits_in_each_set(&lighting, &renderer.dataset.cuts, &point);
        assert!(far.iter().all(|bits| bits == &far[0]), "{far:?}");
        // The material has no diffuse part: the first two, of the Lambert model, are dark.
        assert!(far[0][2..].iter().all(|bits| f32::from_bits(bits[2]) > 0.0), "{far:?}");
        assert_ne!(far[0][2], far[0][3], "negative control: another sampling is another number");
    }

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
