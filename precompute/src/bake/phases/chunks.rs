//! Cuts of many points, chunk by chunk with a checkpoint after each.

use super::pack::unbaked;
use crate::{
    bake::checkpoint::{Chunk, Kept},
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    sources::sampler::{SourceSampler, SourceScratch},
    vertices::{points::BakePoint, visibility::VisibilitySampler},
};
use lapidary_core::{
    cut::{CutCriterion, CutSelector, SourceCriterion, SourceCutSelector},
    ray::BoundaryTracer,
};
use rayon::prelude::*;
use std::ops::Range;

/// Points between two looks at the observer.
pub(super) const POINTS_PER_STEP: usize = 256;

/// Makes the cut of a point.
pub trait CutMaker: Sync {
    /// Buffers kept from point to point.
    type Scratch;

    fn points(&self) -> &[BakePoint];

    /// Height of the tree that the cuts are over.
    fn height(&self) -> u32;

    fn scratch(&self) -> Self::Scratch;

    /// Writes the cut of a point to `cut`, which is empty, and returns its squared error and the rays traced.
    fn make(&self, point: &BakePoint, scratch: &mut Self::Scratch, cut: &mut Vec<u16>) -> (f64, u64);
}

/// Visibility of the environment's lights.
pub struct EnvironmentCuts<'a> {
    pub points: &'a [BakePoint],
    pub sampler: VisibilitySampler<'a>,
    pub height: u32,
    pub criterion: CutCriterion,
}

impl CutMaker for EnvironmentCuts<'_> {
    type Scratch = (CutSelector, BoundaryTracer, Vec<u8>);

    fn points(&self) -> &[BakePoint] {
        self.points
    }

    fn height(&self) -> u32 {
        self.height
    }

    fn scratch(&self) -> Self::Scratch {
        (CutSelector::new(self.height, self.criterion), BoundaryTracer::default(), vec![0; 1 << self.height])
    }

    fn make(
        &self,
        point: &BakePoint,
        (selector, tracer, visible): &mut Self::Scratch,
        cut: &mut Vec<u16>,
    ) -> (f64, u64) {
        let rays = self.sampler.sample(point, tracer, visible);
        (selector.select(visible, cut), rays)
    }
}

/// Solid angles of the surface sources. Squared errors are relative to the squared norm of what was traced.
pub struct SourceCuts<'a> {
    pub points: &'a [BakePoint],
    pub sampler: SourceSampler<'a>,
    pub criterion: SourceCriterion,
}

impl CutMaker for SourceCuts<'_> {
    type Scratch = (SourceCutSelector, SourceScratch, Vec<f32>);

    fn points(&self) -> &[BakePoint] {
        self.points
    }

    fn height(&self) -> u32 {
        self.sampler.len().ilog2()
    }

    fn scratch(&self) -> Self::Scratch {
        let selector = SourceCutSelector::new(self.height(), self.criterion);
        (selector, SourceScratch::default(), vec![0.0; self.sampler.len()])
    }

    fn make(&self, point: &BakePoint, (selector, scratch, seen): &mut Self::Scratch, cut: &mut Vec<u16>) -> (f64, u64) {
        let rays = self.sampler.sample(point, scratch, seen);
        let squared_error = selector.select(seen, cut);
        let squared_norm: f64 = seen.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
        (if squared_norm > 0.0 { squared_error / squared_norm } else { 0.0 }, rays)
    }
}

/// The cuts of all points; chunks that a checkpoint has kept are not made again. Cuts of chunks that other shards make see
/// nothing.
pub fn bake_chunks<M: CutMaker>(maker: &M, kept: &Kept, observer: &dyn Observer) -> Result<Vec<Chunk>, BakeError> {
    let count = maker.points().len();
    let mut chunks = Vec::new();
    for index in 0..kept.chunks() {
        let range = kept.range(count, index);
        if !kept.has(index) {
            chunks.push(unbaked(range.len()));
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
        chunks.push(chunk);
    }
    Ok(chunks)
}

fn bake_chunk<M: CutMaker>(maker: &M, range: Range<usize>, observer: &dyn Observer) -> Result<Chunk, BakeError> {
    let mut chunk = Chunk::default();
    for start in range.clone().step_by(POINTS_PER_STEP) {
        cancelled(observer)?;
        let step = &maker.points()[start..range.end.min(start + POINTS_PER_STEP)];
        let cuts = step.par_iter().map_init(
            || maker.scratch(),
            |scratch, point| {
                let mut cut = Vec::new();
                let (squared_error, rays) = maker.make(point, scratch, &mut cut);
                (cut, squared_error, rays)
            },
        );
        // Collected in order: sums do not depend on which thread was first.
        for (cut, squared_error, rays) in cuts.collect::<Vec<_>>() {
            chunk.push(&cut, squared_error, rays);
        }
        observer.event(Event::Advanced { done: (start + step.len()) as u64 });
    }
    Ok(chunk)
}
