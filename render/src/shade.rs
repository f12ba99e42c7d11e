//! The merge at one pixel (paper, 4.2): three visibility cuts interpolated and multiplied with light and BRDF.
//!
//! `B = Σ |C| <l> <ρ> (w1 <v1> + w2 <v2> + w3 <v3>)` over the merged cut. Nodes with no visibility are dropped before the
//! BRDF is evaluated; the rest is evaluated eight at a time.

use crate::{lighting::SceneLighting, refine::Refinement, surface::SurfacePoint};
use glam::Vec3;
use lapidary_core::{
    cut::{
        merge::merge,
        packed::{PackedCursor, PackedCuts},
    },
    simd::Vec3x8,
};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign};
use wide::f32x8;

/// How the BRDF is sampled on the nodes of the merged cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrdfSampling {
    /// Once a node at its direction, as in the paper (Eq. 6).
    Once,
    /// Nodes too wide for the lobe are halved, and the lobe is filtered by what width remains.
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
    /// Points seen.
    pub points: u64,
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            merged_nodes: self.merged_nodes + other.merged_nodes,
            brdf_evaluations: self.brdf_evaluations + other.brdf_evaluations,
            points: self.points + other.points,
        }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// A node to evaluate: its heap index and the visibility there.
#[derive(Clone, Copy)]
struct Term {
    node: u32,
    visibility: f32,
}

/// Merges and evaluates; keeps its buffers between pixels.
pub struct Shader<'a> {
    lighting: &'a SceneLighting,
    cuts: &'a PackedCuts,
    height: u32,
    sampling: BrdfSampling,
    merged: Vec<Term>,
    terms: Vec<Term>,
    /// Work done so far.
    pub work: Work,
}

impl<'a> Shader<'a> {
    /// For visibility `cuts` over a tree of `height`.
    pub fn new(lighting: &'a SceneLighting, cuts: &'a PackedCuts, height: u32, sampling: BrdfSampling) -> Self {
        Self { lighting, cuts, height, sampling, merged: Vec::new(), terms: Vec::new(), work: Work::default() }
    }

    /// Reflected radiance toward the eye.
    pub fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        self.merge_cuts(point);
        match self.sampling {
            BrdfSampling::Once => std::mem::swap(&mut self.merged, &mut self.terms),
            BrdfSampling::Refine => self.refine(point),
        }
        self.work.brdf_evaluations += self.terms.len() as u64;
        self.evaluate(point)
    }

    /// Fills `merged` with the nodes of the merged cut that see any light.
    fn merge_cuts(&mut self, point: &SurfacePoint) {
        let height = self.height;
        let leaves = 1_u32 << height;
        let visibility = |v: u32| PackedCursor::new(height, self.cuts.nodes_from(v));
        let [a, b, c] = point.vertices;
        let mut cursors = [visibility(a), visibility(b), visibility(c), PackedCursor::new(height, &self.lighting.cut)];
        let weights = point.weights;
        let (merged, mut count) = (&mut self.merged, 0);
        merged.clear();
        merge(leaves, &mut cursors, |interval, cursors| {
            count += 1;
            let visibility =
                weights[0] * cursors[0].value() + weights[1] * cursors[1].value() + weights[2] * cursors[2].value();
            if visibility > 0.0 {
                merged.push(Term { node: interval.heap_index(leaves), visibility });
            }
        });
        self.work.merged_nodes += count;
    }

    /// Fills `terms` with the nodes of `merged`, halved where the BRDF needs it.
    fn refine(&mut self, point: &SurfacePoint) {
        let leaves = 1_u32 << self.height;
        let refinement = Refinement::new(point.brdf.as_brdf().lobe(), point.wo);
        let local_from_world = point.world_from_local.transpose();
        self.terms.clear();
        let mut next = 0;
        // `merged` grows at its end by the halves, which are looked at in turn.
        while let Some(&term) = self.merged.get(next) {
            next += 1;
            let wi = local_from_world * self.lighting.nodes.direction[term.node as usize];
            if term.node < leaves && refinement.wants_halves(self.lighting, term.node as usize, wi) {
                self.merged.push(Term { node: 2 * term.node, ..term });
                self.merged.push(Term { node: 2 * term.node + 1, ..term });
            } else {
                self.terms.push(term);
            }
        }
    }

    /// Sums the terms, eight at a time.
    fn evaluate(&mut self, point: &SurfacePoint) -> Vec3 {
        // Padding repeats the root without visibility.
        self.terms.resize(self.terms.len().next_multiple_of(8), Term { node: 1, visibility: 0.0 });
        let axes = [0, 1, 2].map(|i| Vec3x8::splat(point.world_from_local.col(i)));
        let smooth_normal = Vec3x8::splat(point.smooth_normal);
        let nodes = &self.lighting.nodes;
        let brdf = point.brdf.as_brdf();
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for terms in self.terms.chunks_exact(8) {
            let index: [usize; 8] = std::array::from_fn(|i| terms[i].node as usize);
            let direction = Vec3x8::from_array(index.map(|n| nodes.direction[n]));
            let wi = Vec3x8 { x: direction.dot(axes[0]), y: direction.dot(axes[1]), z: direction.dot(axes[2]) };
            let inv_kappa = match self.sampling {
                BrdfSampling::Once => f32x8::ZERO,
                BrdfSampling::Refine => f32x8::new(index.map(|n| nodes.inv_kappa[n])),
            };
            let size = |t: &Term| (1_u32 << (self.height - t.node.ilog2())) as f32;
            let weight = f32x8::new(std::array::from_fn(|i| terms[i].visibility * size(&terms[i])));
            let received = direction.dot(smooth_normal).simd_gt(f32x8::ZERO) & weight;
            let radiance = Vec3x8::from_array(index.map(|n| nodes.radiance[n]));
            sum = sum + brdf.brdf_cos_x8(wi, point.wo, inv_kappa).scale(radiance) * received;
        }
        sum.reduce_add() * self.lighting.leaf_solid_angle
    }
}
