//! What a bake point sees of the surface sources.

use crate::vertices::points::BakePoint;
use glam::Vec3;
use lapidary_core::{
    ray::{Intersector, SegmentBatch},
    sources::{NearField, Origin, Source},
};

/// Solid angles of all sources from one bake point after another.
pub struct SourceSampler<'a> {
    scene: &'a Intersector,
    sources: &'a [Source],
    /// Where segments to each source end, off its surface.
    ends: Vec<Vec3>,
    near: NearField,
}

/// Buffers of [`SourceSampler::sample`].
#[derive(Default)]
pub struct SourceScratch {
    batch: SegmentBatch,
    /// Sources to trace from the upper and from the lower side.
    wanted: [Vec<u32>; 2],
}

/// The sides of a point: upper, lower.
const SIDES: [bool; 2] = [true, false];

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

    /// Sets `seen[leaf]` to the solid angle in steradians of every source. A far one has that of its disc, or zero if it faces
    /// away, lies below the point's horizon, or is hidden; a near one what rays meet of it. Returns the rays traced.
    pub fn sample(&self, point: &BakePoint, scratch: &mut SourceScratch, seen: &mut [f32]) -> u64 {
        let SourceScratch { batch, wanted } = scratch;
        wanted.iter_mut().for_each(Vec::clear);
        let has_near = self.sort(point, seen, |i, upper| wanted[usize::from(!upper)].push(i as u32));
        for (wanted, upper) in wanted.iter().zip(SIDES) {
            wanted
                .iter()
                .for_each(|&i| seen[i as usize] = self.sources[i as usize].solid_angle_from(point.place(upper)));
            batch.trace(self.scene, point.origin(upper), &self.ends, wanted, |i| seen[i as usize] = 0.0);
        }
        let far: u64 = wanted.iter().map(|w| w.len() as u64).sum();
        far + self.gather_near(point, has_near, seen)
    }

    /// [`Self::sample`] segment by segment and without packets, for verification.
    pub fn sample_singly(&self, point: &BakePoint, seen: &mut [f32]) {
        let mut far = Vec::new();
        let has_near = self.sort(point, seen, |i, upper| far.push((i, upper)));
        for (i, upper) in far {
            let open = !self.scene.occluded_between(point.origin(upper), self.ends[i]);
            seen[i] = if open { self.sources[i].solid_angle_from(point.place(upper)) } else { 0.0 };
        }
        self.gather_near(point, has_near, seen);
    }

    /// Calls `far` with each source to trace and the side of the point that faces it, sets all others to zero, and tells
    /// for each side whether there are near sources.
    fn sort(&self, point: &BakePoint, seen: &mut [f32], mut far: impl FnMut(usize, bool)) -> [bool; 2] {
        let mut has_near = [false; 2];
        for (i, (source, seen)) in self.sources.iter().zip(seen.iter_mut()).enumerate() {
            *seen = 0.0;
            match facing_side(point, source) {
                Some(upper) if self.near.holds(source, point.origin(upper)) => {
                    has_near[usize::from(!upper)] |= self.near.is_over(source, point.place(upper));
                }
                Some(upper) => far(i, upper),
                None => (),
            }
        }
        has_near
    }

    /// Adds what the sides of a point with near sources see of them, and returns the rays traced.
    fn gather_near(&self, point: &BakePoint, has_near: [bool; 2], seen: &mut [f32]) -> u64 {
        let gather = |(upper, _)| {
            let normal = if upper { point.normal } else { -point.normal };
            let origin = Origin {
                position: point.origin(upper),
                anchor: point.position + normal * point.offset,
                normal,
                face: normal,
                lift: point.offset,
                own_cosine: point.own_cosine(),
            };
            let receives = |d| point.is_upper(d) == upper;
            self.near.gather(self.sources, self.scene, origin, receives, |i, angle| seen[i] += angle)
        };
        SIDES.into_iter().zip(has_near).filter(|&(_, near)| near).map(gather).sum()
    }
}

/// Whether a source lies on the upper side of a point (or on the lower), if both face each other.
#[inline]
fn facing_side(point: &BakePoint, source: &Source) -> Option<bool> {
    let toward = source.surfel.position - point.position;
    let upper = !point.two_sided || point.is_upper(toward);
    let faces = source.solid_angle_from(point.place(upper)) > 0.0;
    (faces && (point.two_sided || point.is_upper(toward.normalize_or_zero()))).then_some(upper)
}

#[cfg(test)]
mod tests;
