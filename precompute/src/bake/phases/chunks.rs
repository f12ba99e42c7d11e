//! Cuts of many points, chunk by chunk with a checkpoint after each.

use super::point_cuts::{PointCuts, unbaked};
use crate::{
    bake::checkpoint::{Chunk, Kept},
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    sources::{
        error::squared_norm,
        sampler::{SourceSampler, SourceScratch},
    },
    vertices::{
        points::BakePoint,
        tracing::{ManySampler, POINTS_AT_A_TIME},
    },
};
use lapidary_core::cut::{CutCriterion, CutSelector, SourceCriterion, SourceCutSelector, solid_angle_error};
use rayon::prelude::*;
use std::ops::Range;

/// The cut of a point, its squared error, and the rays traced for it.
pub type MadeCut = (Vec<u16>, f64, u64);

/// Computes the cuts of points.
pub trait CutMaker {
    /// Number of points.
    fn points(&self) -> usize;

    /// Height of the tree below the cuts.
    fn height(&self) -> u32;

    /// Points between checks for cancellation.
    fn points_per_step(&self) -> usize {
        POINTS_AT_A_TIME
    }

    /// The cuts of some points in order, computed on all cores.
    ///
    /// # Errors
    /// A device error.
    fn make(&self, points: Range<usize>) -> Result<Vec<MadeCut>, BakeError>;
}

/// Visibility of the environment's lights.
pub struct EnvironmentCuts<'a> {
    pub points: &'a [BakePoint],
    pub sampler: ManySampler<'a>,
    pub height: u32,
    pub criterion: CutCriterion,
}

impl CutMaker for EnvironmentCuts<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn height(&self) -> u32 {
        self.height
    }

    fn points_per_step(&self) -> usize {
        self.sampler.points_at_a_time()
    }

    fn make(&self, points: Range<usize>) -> Result<Vec<MadeCut>, BakeError> {
        let points: Vec<&BakePoint> = self.points[points].iter().collect();
        let selector = || CutSelector::new(self.height, self.criterion);
        Ok(self.sampler.each(&points, selector, |selector, visible, rays| {
            let mut cut = Vec::new();
            let squared_error = selector.select(visible, &mut cut);
            (cut, squared_error, rays)
        }))
    }
}

/// Solid angles of the surface sources. Squared errors are relative to the squared norm of the traced values.
pub struct SourceCuts<'a> {
    pub points: &'a [BakePoint],
    pub sampler: SourceSampler<'a>,
    pub criterion: SourceCriterion,
}

impl CutMaker for SourceCuts<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn height(&self) -> u32 {
        self.sampler.len().ilog2()
    }

    fn make(&self, points: Range<usize>) -> Result<Vec<MadeCut>, BakeError> {
        let scratch = || {
            let selector = SourceCutSelector::new(self.height(), self.criterion);
            (selector, SourceScratch::default(), vec![0.0; self.sampler.len()])
        };
        let one = |(selector, scratch, seen): &mut (SourceCutSelector, SourceScratch, Vec<f32>), point: &BakePoint| {
            let rays = self.sampler.sample(point, scratch, seen);
            let mut cut = Vec::new();
            selector.select(seen, &mut cut);
            let squared_norm = squared_norm(seen);
            let squared_error = solid_angle_error(self.height(), &cut, seen);
            (cut, if squared_norm > 0.0 { squared_error / squared_norm } else { 0.0 }, rays)
        };
        Ok(self.points[points].par_iter().map_init(scratch, one).collect())
    }
}

/// The cuts of all points; chunks in the checkpoint are not recomputed. Cuts in other shards' chunks are fully occluded.
pub fn bake_chunks<'a, M: CutMaker>(
    maker: &M,
    kept: &'a Kept<'a>,
    observer: &dyn Observer,
) -> Result<PointCuts<'a>, BakeError> {
    let count = maker.points();
    let mut cuts = PointCuts::new(maker.height());
    for index in 0..kept.chunks() {
        let range = kept.range(count, index);
        if !kept.has(index) {
            cuts.push(unbaked(range.len()));
            continue;
        }
        let chunk = match kept.load(index, range.len(), maker.height()) {
            Some(chunk) => chunk,
            None => {
                kept.may_make(index)?;
                let chunk = bake_chunk(maker, range.clone(), observer)?;
                kept.store(index, &chunk)?;
                chunk
            }
        };
        observer.event(Event::Advanced { done: range.end as u64 });
        cuts.push_kept(chunk, kept, index);
    }
    Ok(cuts)
}

/// The cuts of some points.
pub fn bake_chunk<M: CutMaker>(maker: &M, range: Range<usize>, observer: &dyn Observer) -> Result<Chunk, BakeError> {
    let mut chunk = Chunk::default();
    let mut start = range.start;
    while start < range.end {
        cancelled(observer)?;
        // Asked each time: a device may fail, and the cores then take smaller steps.
        let step = start..range.end.min(start + maker.points_per_step());
        for (cut, squared_error, rays) in maker.make(step.clone())? {
            chunk.push(&cut, squared_error, rays);
        }
        start = step.end;
        observer.event(Event::Advanced { done: start as u64 });
    }
    Ok(chunk)
}
