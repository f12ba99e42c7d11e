//! Cuts of points, renewed where an edit reaches.

use super::{
    change::Change,
    reach::{LightReach, SourceReach},
};
use crate::{
    bake::phases::chunks::{CutMaker, MadeCut},
    errors::BakeError,
    sources::sampler::{SourceSampler, SourceScratch},
    vertices::{points::BakePoint, visibility::VisibilitySampler},
};
use lapidary_core::{
    cut::{
        CutCriterion, CutPart, CutSelector, SourceCriterion, SourceCutSelector, cut_parts, is_uniform_solid_angle,
        is_uniform_visibility, leaves_below, packed::PackedCuts,
    },
    dataset::Dataset,
    ray::{BoundaryTracer, Intersector},
    sources::Source,
};
use rayon::prelude::*;
use std::ops::Range;

/// The cuts before an edit.
pub struct OldCuts<'a> {
    cuts: &'a PackedCuts,
    height: u32,
    /// The cut of each point; none for one that moved.
    of_point: Vec<Option<u32>>,
    /// Whether a node says what each of its leaves is.
    is_uniform: fn(u32, u16) -> bool,
}

impl<'a> OldCuts<'a> {
    /// Cuts of visibility over a tree of `height`.
    pub fn of_visibility(cuts: &'a PackedCuts, height: u32, of_point: Vec<Option<u32>>) -> Self {
        Self { cuts, height, of_point, is_uniform: is_uniform_visibility }
    }

    /// Cuts of solid angles over a tree of `height`.
    pub fn of_solid_angles(cuts: &'a PackedCuts, height: u32, of_point: Vec<Option<u32>>) -> Self {
        Self { cuts, height, of_point, is_uniform: is_uniform_solid_angle }
    }

    fn of(&self, point: usize) -> Option<&[u16]> {
        self.of_point[point].map(|cut| self.cuts.cut(self.height, cut))
    }

    /// The cut of a point: the old one where the edit reaches no part of it, else one that `select` makes of its parts. `stale` tells
    /// which granules the edit reaches; the leaves below stale parts are marked.
    fn renewed(
        &self,
        point: usize,
        marked: &mut [bool],
        stale: impl FnOnce(&mut Vec<bool>),
        select: impl FnOnce(&[CutPart], &[bool]) -> MadeCut,
    ) -> MadeCut {
        let Some(old) = self.of(point) else {
            marked.fill(true);
            return select(&CutPart::ALL, marked);
        };
        let mut is_stale = Vec::new();
        stale(&mut is_stale);
        let parts = cut_parts(self.height, old, &is_stale, self.is_uniform);
        if mark(self.height, &parts, marked) { select(&parts, marked) } else { (old.to_vec(), 0.0, 0) }
    }
}

/// Marks the leaves below stale parts. Returns whether there are any.
fn mark(height: u32, parts: &[CutPart], marked: &mut [bool]) -> bool {
    marked.fill(false);
    let mut any = false;
    for part in parts {
        if let CutPart::Stale(node) = part {
            marked[leaves_below(height, *node)].fill(true);
            any = true;
        }
    }
    any
}

/// Visibility of the environment's lights.
pub struct RenewedEnvironment<'a> {
    points: &'a [BakePoint],
    old: OldCuts<'a>,
    reach: LightReach<'a>,
    sampler: VisibilitySampler<'a>,
    criterion: CutCriterion,
}

impl<'a> RenewedEnvironment<'a> {
    /// For points with their cuts before the edit. Bounds are those that the bake held.
    pub fn new(
        before: &'a Dataset,
        scene: &'a Intersector,
        (points, old): (&'a [BakePoint], OldCuts<'a>),
        change: &'a Change,
    ) -> Self {
        let criterion = before.settings.criterion;
        Self {
            points,
            old,
            reach: LightReach::new(before.tree.leaf_directions(), change),
            sampler: VisibilitySampler::new(scene, &before.tree, before.report.lights_per_probe()),
            criterion: CutCriterion { sigma: before.report.sigma.max(criterion.sigma), ..criterion },
        }
    }
}

impl CutMaker for RenewedEnvironment<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn height(&self) -> u32 {
        self.old.height
    }

    fn make(&self, points: Range<usize>) -> Result<Vec<MadeCut>, BakeError> {
        let leaves = self.sampler.len();
        let scratch = || {
            let selector = CutSelector::new(self.old.height, self.criterion);
            (selector, BoundaryTracer::default(), vec![0; leaves], vec![false; leaves])
        };
        type Buffers = (CutSelector, BoundaryTracer, Vec<u8>, Vec<bool>);
        let one = |(selector, tracer, visible, marked): &mut Buffers, index: usize| {
            let point = &self.points[index];
            self.old.renewed(
                index,
                marked,
                |stale| self.reach.stale(point, stale),
                |parts, marked| {
                    // A bound on the whole cut needs all leaves.
                    let is_local = self.criterion.is_local(leaves);
                    let parts = if is_local { parts } else { &CutPart::ALL };
                    let rays = self.sampler.sample_some(point, is_local.then_some(marked), tracer, visible);
                    let mut cut = Vec::new();
                    let squared_error = selector.select_parts(visible, parts, &mut cut);
                    (cut, squared_error, rays)
                },
            )
        };
        Ok(points.into_par_iter().map_init(scratch, one).collect())
    }
}

/// Solid angles of the surface sources.
pub struct RenewedSources<'a> {
    points: &'a [BakePoint],
    old: OldCuts<'a>,
    reach: SourceReach<'a>,
    sampler: SourceSampler<'a>,
    criterion: SourceCriterion,
}

impl<'a> RenewedSources<'a> {
    /// For points with their cuts before the edit, and sources after and before it.
    pub fn new(
        before: &'a Dataset,
        sampler: SourceSampler<'a>,
        (sources, sources_before): (&'a [Source], &[Source]),
        (points, old): (&'a [BakePoint], OldCuts<'a>),
        change: &'a Change,
    ) -> Self {
        let asked = before.settings.indirect.criterion;
        let criterion = before.report.indirect.as_ref().map_or(asked, |report| report.criterion(asked));
        Self { points, old, reach: SourceReach::new(sources, sources_before, change), sampler, criterion }
    }
}

impl CutMaker for RenewedSources<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn height(&self) -> u32 {
        self.old.height
    }

    fn make(&self, points: Range<usize>) -> Result<Vec<MadeCut>, BakeError> {
        let sources = self.sampler.len();
        let scratch = || {
            let selector = SourceCutSelector::new(self.old.height, self.criterion);
            (selector, SourceScratch::default(), vec![0.0; sources], vec![false; sources])
        };
        type Buffers = (SourceCutSelector, SourceScratch, Vec<f32>, Vec<bool>);
        let one = |(selector, scratch, seen, marked): &mut Buffers, index: usize| {
            let point = &self.points[index];
            self.old.renewed(
                index,
                marked,
                |stale| self.reach.stale(point, stale),
                |parts, marked| {
                    let rays = self.sampler.sample_some(point, |source| marked[source], scratch, seen);
                    let mut cut = Vec::new();
                    selector.select_parts(seen, parts, &mut cut);
                    (cut, 0.0, rays)
                },
            )
        };
        Ok(points.into_par_iter().map_init(scratch, one).collect())
    }
}
