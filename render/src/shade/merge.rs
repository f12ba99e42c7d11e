//! The merge at one pixel (paper, 4.2): three cuts, interpolated and multiplied by light and BRDF.
//!
//! `B = Σ |C| <l> <ρ> (w1 <v1> + w2 <v2> + w3 <v3>)` over the merged cut. The paper merges the stored cuts with an illumination cut
//! and samples the BRDF once per node or, refined, more finely. Lit cuts contain the light already and need no illumination cut:
//! within the pixel's lobe, the merge descends into the stored cuts and on into the light tree. It drops nodes without visibility
//! before the BRDF and evaluates the others eight at a time. One traversal serves the environment and the surface sources, see
//! [`NodeField`]; [`super::merged`] finds the nodes. Twin of `shaders/merge_pass.wgsl`: the same terms.

use crate::{
    light::mirrored_map::MirroredMap,
    sampling::BrdfSampling,
    shade::{
        merged::{Found, Merged},
        mirror::{Mirror, rays::RayLobes},
        node_field::{EightLights, NodeField},
        surface::{ReceiverX8, SurfacePoint},
    },
};
use glam::Vec3;
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor},
    cut::{merge::Interval, packed::PackedCuts},
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
};
use std::{
    marker::PhantomData,
    ops::{Add, AddAssign},
};
use wide::f32x8;

/// Work for one or more pixels.
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
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    /// Heap index.
    pub node: u32,
    /// Leaves below the node; zero in padding.
    pub leaves: f32,
    /// Interpolated value of the vertices' cuts; zero in padding and for nodes that only a [`Mirror`] requests.
    pub visibility: f32,
    /// Whether the node comes from lit cuts: its value is then a light-weighted mean.
    pub is_lit: bool,
}

impl Term {
    /// Padding for groups of eight: the root without leaves.
    pub(super) const PADDING: Self = Self { node: 1, leaves: 0.0, visibility: 0.0, is_lit: false };

    /// Both children.
    #[inline(always)]
    pub(super) fn halves(self) -> [Self; 2] {
        let half = Self { node: 2 * self.node, leaves: 0.5 * self.leaves, ..self };
        [half, Self { node: half.node + 1, ..half }]
    }
}

/// Eight terms of the sum, evaluated.
pub(crate) struct EightTerms<'t, L = f32x8> {
    pub terms: &'t [Term],
    /// Unit directions to the nodes in world space.
    pub direction: Vec3x8<L>,
    /// The same directions in the local frame.
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

    /// Reflected light if all nodes were visible.
    #[inline(always)]
    fn unshadowed(&self) -> Vec3x8<L> {
        self.brdf_cos.scale(self.radiance) * self.leaves
    }
}

/// Where the light of sharp lobes comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SharpLight {
    /// From the map of the light samples, if they have one, by its visible share.
    Map,
    /// From rays, see [`RayLobes`]: the cuts give none. What is sharp depends on the solid angle of a light sample; `of_surfaces`
    /// tells whether wider lobes have rays for surfaces, whose light is `brightest` at most: the rest stays with the cuts.
    Rays { leaf_solid_angle: f32, of_surfaces: bool, brightest: f32 },
}

impl SharpLight {
    /// Lobes at a point that have rays.
    pub fn lobes(self, point: &SurfacePoint) -> Option<RayLobes> {
        match self {
            Self::Map => None,
            Self::Rays { leaf_solid_angle, of_surfaces: true, .. } => RayLobes::at(point, leaf_solid_angle),
            Self::Rays { leaf_solid_angle, of_surfaces: false, .. } => RayLobes::of_map(point, leaf_solid_angle),
        }
    }

    /// Most light of a surface that rays of wider lobes show, as a luminance.
    #[inline(always)]
    pub fn brightest(self) -> f32 {
        match self {
            Self::Map => f32::INFINITY,
            Self::Rays { brightest, .. } => brightest,
        }
    }

    /// The same for light of the environment: wider lobes have no rays.
    pub fn of_environment(self) -> Self {
        match self {
            Self::Map => Self::Map,
            Self::Rays { leaf_solid_angle, brightest, .. } => {
                Self::Rays { leaf_solid_angle, of_surfaces: false, brightest }
            }
        }
    }
}

/// Merges and evaluates cuts; keeps its buffers between pixels.
pub struct Shader<'a, F> {
    pub(super) field: F,
    pub(super) cuts: &'a PackedCuts,
    pub(super) sampling: BrdfSampling,
    pub(super) sharp: SharpLight,
    /// Whether the cuts include the surface's horizon: vertices see nothing below it.
    knows_horizon: bool,
    found: Found,
    instructions: InstructionSet,
    /// Work done so far.
    pub work: Work,
}

impl<'a, F: NodeField> Shader<'a, F> {
    /// Creates a shader for visibility `cuts` over the tree of `field`.
    pub fn new(field: F, cuts: &'a PackedCuts, sampling: BrdfSampling) -> Self {
        let (instructions, found, work) = (InstructionSet::widest(), Found::default(), Work::default());
        Self { field, cuts, sampling, sharp: SharpLight::Map, knows_horizon: true, found, instructions, work }
    }

    /// Creates a shader for `cuts` without any occlusion, not even by the surface itself.
    pub fn unoccluded(field: F, cuts: &'a PackedCuts) -> Self {
        Self { knows_horizon: false, ..Self::new(field, cuts, BrdfSampling::Refine) }
    }

    /// Reflected radiance toward the eye.
    pub fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        self.instructions.run(Shade { shader: self, point })
    }

    /// Sharp lobes at a point that read the light's map, if it has one.
    fn mirror(&self, point: &SurfacePoint) -> Option<(Mirror, &'a MirroredMap)>
    where
        F: 'a,
    {
        let may_read = self.sharp == SharpLight::Map && self.sampling != BrdfSampling::Once;
        let map = self.field.mirrored().filter(|_| may_read)?;
        Some((Mirror::at(point, self.field.solid_angle())?, map))
    }

    /// Lobes at a point that have rays for this light.
    fn ray_lobes(&self, point: &SurfacePoint) -> Option<RayLobes> {
        let is_of_environment = self.field.mirrored().is_some();
        if is_of_environment { self.sharp.of_environment() } else { self.sharp }.lobes(point)
    }

    /// Visits the terms of the sum without a [`Mirror`], in any order, after the nodes of the merged cut without visible light,
    /// left to right.
    #[inline(always)]
    pub fn traverse<L: Lanes>(
        &mut self,
        point: &SurfacePoint,
        dark: impl FnMut(Interval),
        visit: impl FnMut(&EightTerms<L>),
    ) {
        self.traverse_with(point, [None; 2], dark, visit);
    }

    /// [`Self::traverse`] for a mirror, including nodes without visible light that reach into the window of one that reads the map.
    #[inline(always)]
    fn traverse_with<L: Lanes>(
        &mut self,
        point: &SurfacePoint,
        [mirror, of_map]: [Option<&Mirror>; 2],
        dark: impl FnMut(Interval),
        visit: impl FnMut(&EightTerms<L>),
    ) {
        let mut found = std::mem::take(&mut self.found);
        self.work.merged_nodes += Merged::new(self, point, of_map).find::<L>(&mut found, dark);
        self.work.brdf_evaluations += found.terms.len() as u64;
        self.evaluate(point, mirror, found.terms.eights(), visit);
        self.found = found;
    }

    /// Evaluates the terms, eight at a time.
    #[inline(always)]
    fn evaluate<L: Lanes>(
        &self,
        point: &SurfacePoint,
        mirror: Option<&Mirror>,
        terms: &[[Term; 8]],
        visit: impl FnMut(&EightTerms<L>),
    ) {
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
            let EightLights { direction, inv_kappa, moments, radiance } =
                self.field.light::<L>(nodes, point.position, spread);
            let mut lights = match self.knows_horizon {
                true => receiver.lights(direction, inv_kappa, &moments),
                false => receiver.lights_at_centers(direction, inv_kappa),
            };
            if let Some(mirror) = mirror {
                lights.spread.inv_kappa = mirror.spread(lights.wi, lights.spread.inv_kappa);
            }
            let (brdf_cos, [weight, leaves]) = (brdf.reflect(&lights, point.wo), weights(terms));
            visit(&EightTerms { terms, direction, wi: lights.wi, radiance, brdf_cos, weight, leaves });
        }
    }
}

/// Visibility times number of leaves, and number of leaves.
#[inline(always)]
fn weights<L: Lanes>(terms: &[Term; 8]) -> [L; 2] {
    let (mut visibility, mut leaves) = ([0.0; 8], [0.0; 8]);
    for ((visibility, leaves), term) in visibility.iter_mut().zip(&mut leaves).zip(terms) {
        (*visibility, *leaves) = (term.visibility, term.leaves);
    }
    let leaves = L::new(leaves);
    [L::new(visibility) * leaves, leaves]
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

/// [`Shader::shade`] in the machine's instruction set.
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
        let (rays, brightest) = (shader.ray_lobes(point), shader.sharp.brightest());
        let mut sums = [Vec3x8::<L>::splat(Vec3::ZERO); 3];
        let [reflected, seen, all] = &mut sums;
        let of_map = mirror.as_ref().map(|(mirror, _)| mirror);
        shader.traverse_with::<L>(
            point,
            [of_map.or(rays.as_ref().and_then(RayLobes::narrowing)), of_map],
            |_| (),
            #[inline(always)]
            |eight| {
                *reflected = *reflected + eight.reflected();
                if let Some(rays) = &rays {
                    *seen = *seen + eight.reflected() * rays.share_below(eight.wi, eight.radiance, brightest);
                }
                if let Some((mirror, _)) = &mirror {
                    let window = mirror.window(eight.wi);
                    *seen = *seen + eight.reflected() * window;
                    *all = *all + eight.unshadowed() * window;
                }
            },
        );
        let per_leaf = shader.field.solid_angle();
        let reflected = reflected.reduce_add() * per_leaf;
        let Some((mirror, map)) = mirror else { return (reflected - seen.reduce_add() * per_leaf).max(Vec3::ZERO) };
        mirror.sharpened(
            reflected,
            seen.reduce_add() * per_leaf,
            all.reduce_add() * per_leaf,
            #[inline(always)]
            || mirror.unshadowed::<L>(point, map),
        )
    }
}

#[cfg(test)]
mod tests;
