//! Solid angles of the surface sources as seen from a bake point.

use crate::vertices::{points::BakePoint, side::Side, visibility::EXHAUSTIVE};
use glam::Vec3;
use lapidary_core::{
    ray::{Intersector, SegmentBatch, SegmentSet, SegmentTracer},
    sources::{NearField, Origin, Source},
    surfel::GradedGrid,
};
use rayon::prelude::*;

/// Nearest sources that count as neighbors: a point of a Poisson-disk set touches six others.
const NEIGHBOURS: usize = 6;
/// Neighbors are searched within this many spacings.
const NEIGHBOUR_REACH: f32 = 4.0;

/// Samples the solid angles of all sources, one bake point after another.
pub struct SourceSampler<'a> {
    scene: &'a Intersector,
    sources: &'a [Source],
    /// Ends of the segments to the sources, off their surfaces.
    ends: Vec<Vec3>,
    /// Share of light that each source's surface blocks, if any of them is thin.
    opacities: Option<Vec<f32>>,
    near: NearField,
    /// Set in which boundaries are followed; `None` if all segments are traced.
    boundaries: Option<SegmentSet>,
}

/// Buffers of [`SourceSampler::sample`].
#[derive(Default)]
pub struct SourceScratch {
    batch: SegmentBatch,
    tracer: SegmentTracer,
    /// Sources to trace from the front and from the back.
    wanted: [Vec<u32>; 2],
}

impl<'a> SourceSampler<'a> {
    /// For sources in tree order; segments end `offset` meters off their surface. Boundaries are followed between probes that each
    /// stand for `sources_per_probe`, or every segment is traced ([`EXHAUSTIVE`]).
    pub fn new(scene: &'a Intersector, sources: &'a [Source], offset: f32, sources_per_probe: usize) -> Self {
        let ends: Vec<Vec3> = sources.iter().map(|s| s.surfel.position + s.surfel.normal * offset).collect();
        let boundaries = (sources_per_probe != EXHAUSTIVE)
            .then(|| SegmentSet::new(ends.clone(), &neighbours(sources), sources_per_probe));
        let opacity = |source: &Source| scene.opacity_at(source.surfel.place);
        let opacities = scene.has_veils().then(|| sources.iter().map(opacity).collect());
        Self { scene, sources, ends, opacities, near: NearField::new(sources), boundaries }
    }

    /// Share of a distant source's light that passes thin surfaces; below 1 for a source on such a surface.
    fn passed(&self, origin: Vec3, source: usize) -> f32 {
        let Some(opacities) = &self.opacities else { return 1.0 };
        opacities[source] * self.scene.past_veils_between(origin, self.ends[source])
    }

    /// Number of sources.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Sets `seen[leaf]` to the solid angle in steradians of every source. A distant source has its disc's solid angle, or zero if
    /// it faces away, lies below the point's horizon, or is hidden; rays determine near ones. Returns the number of traced rays.
    pub fn sample(&self, point: &BakePoint, scratch: &mut SourceScratch, seen: &mut [f32]) -> u64 {
        self.sample_some(point, |_| true, scratch, seen)
    }

    /// [`Self::sample`] for some sources; the values of others have no meaning.
    pub fn sample_some(
        &self,
        point: &BakePoint,
        is_wanted: impl Fn(usize) -> bool,
        scratch: &mut SourceScratch,
        seen: &mut [f32],
    ) -> u64 {
        let SourceScratch { batch, tracer, wanted } = scratch;
        wanted.iter_mut().for_each(Vec::clear);
        let has_near = self.sort(point, seen, is_wanted, |i, side| wanted[side as usize].push(i as u32));
        let mut far = 0;
        for (wanted, side) in wanted.iter().zip(Side::BOTH).filter(|(wanted, _)| !wanted.is_empty()) {
            let origin = point.origin(side);
            wanted
                .iter()
                .for_each(|&i| seen[i as usize] = self.sources[i as usize].solid_angle_from(point.place(side)));
            let hidden = |i: u32| seen[i as usize] = 0.0;
            far += match &self.boundaries {
                Some(set) => tracer.trace(self.scene, origin, set, wanted, hidden),
                None => batch.trace(self.scene, origin, &self.ends, wanted, hidden),
            };
            wanted.iter().for_each(|&i| seen[i as usize] *= self.passed(origin, i as usize));
        }
        let near = |origin, receives: &dyn Fn(Vec3) -> bool, add: &mut dyn FnMut(usize, f32)| {
            self.near.gather(self.sources, self.scene, origin, receives, add)
        };
        far + gather_near(point, has_near, seen, near)
    }

    /// [`Self::sample`] by single segments and rays, for verification.
    pub fn sample_singly(&self, point: &BakePoint, seen: &mut [f32]) {
        let mut far = Vec::new();
        let has_near = self.sort(point, seen, |_| true, |i, side| far.push((i, side)));
        for (i, side) in far {
            let open = !self.scene.occluded_between(point.origin(side), self.ends[i]);
            let solid_angle = self.sources[i].solid_angle_from(point.place(side));
            seen[i] = if open { solid_angle * self.passed(point.origin(side), i) } else { 0.0 };
        }
        gather_near(point, has_near, seen, |origin, receives, add| {
            self.near.gather_singly(self.sources, self.scene, origin, receives, add)
        });
    }

    /// Repeats [`Self::sample`] for verification: by single segments if all are traced, else along the same boundaries.
    pub fn sample_again(&self, point: &BakePoint, seen: &mut [f32]) {
        match self.boundaries {
            None => self.sample_singly(point, seen),
            Some(_) => {
                self.sample(point, &mut SourceScratch::default(), seen);
            }
        }
    }

    /// Calls `far` with each wanted source to trace and the side of the point that faces it, and sets all others to zero.
    /// Returns for each side whether it has near ones that are wanted.
    fn sort(
        &self,
        point: &BakePoint,
        seen: &mut [f32],
        is_wanted: impl Fn(usize) -> bool,
        mut far: impl FnMut(usize, Side),
    ) -> [bool; 2] {
        let mut has_near = [false; 2];
        seen.fill(0.0);
        for (i, source) in self.sources.iter().enumerate().filter(|(i, _)| is_wanted(*i)) {
            match facing_side(point, source) {
                Some(side) if self.near.holds(source, point.origin(side)) => {
                    has_near[side as usize] |= self.near.is_over(source, point.place(side));
                }
                Some(side) => far(i, side),
                None => (),
            }
        }
        has_near
    }
}

/// Adds the solid angles of near sources, computed by `gather`, for the sides of a point that have any. Returns the number of
/// traced rays.
fn gather_near(
    point: &BakePoint,
    has_near: [bool; 2],
    seen: &mut [f32],
    gather: impl Fn(Origin, &dyn Fn(Vec3) -> bool, &mut dyn FnMut(usize, f32)) -> u64,
) -> u64 {
    let mut rays = 0;
    for (side, _) in Side::BOTH.into_iter().zip(has_near).filter(|&(_, near)| near) {
        let normal = side.normal(point.normal);
        let origin = Origin {
            position: point.origin(side),
            anchor: point.position + normal * point.offset,
            normal,
            face: normal,
            lift: point.offset,
            same_surface_cosine: point.same_surface_cosine(),
        };
        rays += gather(origin, &|d| point.side_of(d) == side, &mut |i, angle| seen[i] += angle);
    }
    rays
}

/// Nearest other sources of each source, on its own surface.
fn neighbours(sources: &[Source]) -> Vec<Vec<u32>> {
    let grid = GradedGrid::of(sources.iter().map(|source| (source.surfel, NEIGHBOUR_REACH * source.spacing)));
    let nearest = |(own, source): (usize, &Source)| {
        let mut others = Vec::new();
        grid.any_reaching(&source.surfel, |i, distance| {
            others.extend((i != own).then_some((distance, i as u32)));
            false
        });
        others.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        others.into_iter().take(NEIGHBOURS).map(|(_, i)| i).collect()
    };
    sources.par_iter().enumerate().map(nearest).collect()
}

/// The side of a point that faces a source, if both face each other.
#[inline]
fn facing_side(point: &BakePoint, source: &Source) -> Option<Side> {
    let toward = source.surfel.position - point.position;
    let side = if point.two_sided { point.side_of(toward) } else { Side::Front };
    let is_above = || point.two_sided || point.side_of(toward.normalize_or_zero()) == Side::Front;
    (source.faces(point.place(side)) && is_above()).then_some(side)
}

#[cfg(test)]
mod tests;
