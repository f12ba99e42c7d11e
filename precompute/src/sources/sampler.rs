//! Solid angles of the surface sources as seen from a bake point.

use crate::vertices::{points::BakePoint, side::Side};
use glam::Vec3;
use lapidary_core::{
    ray::{Intersector, SegmentBatch},
    sources::{NearField, Origin, Source},
};

/// Samples the solid angles of all sources, one bake point after another.
pub struct SourceSampler<'a> {
    scene: &'a Intersector,
    sources: &'a [Source],
    /// End of the segments to each source, off its surface.
    ends: Vec<Vec3>,
    near: NearField,
}

/// Buffers of [`SourceSampler::sample`].
#[derive(Default)]
pub struct SourceScratch {
    batch: SegmentBatch,
    /// Sources to trace from the front and from the back.
    wanted: [Vec<u32>; 2],
}

impl<'a> SourceSampler<'a> {
    /// For sources in tree order; segments end `offset` metres off their surface.
    pub fn new(scene: &'a Intersector, sources: &'a [Source], offset: f32) -> Self {
        let ends = sources.iter().map(|s| s.surfel.position + s.surfel.normal * offset).collect();
        Self { scene, sources, ends, near: NearField::new(sources) }
    }

    /// Number of sources.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Sets `seen[leaf]` to the solid angle in steradians of every source. A distant source has that of its disc, or
    /// zero if it faces away, lies below the point's horizon, or is hidden; for a near one the rays decide. Returns the
    /// number of rays traced.
    pub fn sample(&self, point: &BakePoint, scratch: &mut SourceScratch, seen: &mut [f32]) -> u64 {
        let SourceScratch { batch, wanted } = scratch;
        wanted.iter_mut().for_each(Vec::clear);
        let has_near = self.sort(point, seen, |i, side| wanted[side as usize].push(i as u32));
        for (wanted, side) in wanted.iter().zip(Side::BOTH) {
            wanted
                .iter()
                .for_each(|&i| seen[i as usize] = self.sources[i as usize].solid_angle_from(point.place(side)));
            batch.trace(self.scene, point.origin(side), &self.ends, wanted, |i| seen[i as usize] = 0.0);
        }
        let far: u64 = wanted.iter().map(|w| w.len() as u64).sum();
        far + self.gather_near(point, has_near, seen)
    }

    /// [`Self::sample`] segment by segment and without packets, for verification.
    pub fn sample_singly(&self, point: &BakePoint, seen: &mut [f32]) {
        let mut far = Vec::new();
        let has_near = self.sort(point, seen, |i, side| far.push((i, side)));
        for (i, side) in far {
            let open = !self.scene.occluded_between(point.origin(side), self.ends[i]);
            seen[i] = if open { self.sources[i].solid_angle_from(point.place(side)) } else { 0.0 };
        }
        self.gather_near(point, has_near, seen);
    }

    /// Calls `far` with each source to trace and the side of the point that faces it, and sets all others to zero.
    /// Returns for each side whether it has near sources.
    fn sort(&self, point: &BakePoint, seen: &mut [f32], mut far: impl FnMut(usize, Side)) -> [bool; 2] {
        let mut has_near = [false; 2];
        for (i, (source, seen)) in self.sources.iter().zip(seen.iter_mut()).enumerate() {
            *seen = 0.0;
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

    /// Adds solid angles of near sources for the sides of a point that have any. Returns the number of rays traced.
    fn gather_near(&self, point: &BakePoint, has_near: [bool; 2], seen: &mut [f32]) -> u64 {
        let gather = |(side, _): (Side, bool)| {
            let normal = side.normal(point.normal);
            let origin = Origin {
                position: point.origin(side),
                anchor: point.position + normal * point.offset,
                normal,
                face: normal,
                lift: point.offset,
                same_surface_cosine: point.same_surface_cosine(),
            };
            let receives = |d| point.side_of(d) == side;
            self.near.gather(self.sources, self.scene, origin, receives, |i, angle| seen[i] += angle)
        };
        Side::BOTH.into_iter().zip(has_near).filter(|&(_, near)| near).map(gather).sum()
    }
}

/// The side of a point that a source is on, if both face each other.
#[inline]
fn facing_side(point: &BakePoint, source: &Source) -> Option<Side> {
    let toward = source.surfel.position - point.position;
    let side = if point.two_sided { point.side_of(toward) } else { Side::Front };
    let faces = source.solid_angle_from(point.place(side)) > 0.0;
    (faces && (point.two_sided || point.side_of(toward.normalize_or_zero()) == Side::Front)).then_some(side)
}

#[cfg(test)]
mod tests;
