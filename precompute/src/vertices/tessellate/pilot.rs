//! Error of linear interpolation of visibility at the middle of an edge.

use super::{
    edges::{Edges, end_vertices},
    pilot_device::PilotDevice,
};
use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    vertices::{
        points::{BakePoint, BakePoints},
        sidedness::{Sidedness, exact_key},
        tracing::origins_of,
        until_failure::UntilFailure,
        z_order::z_order,
    },
};
use glam::Vec3;
use lapidary_core::{
    dataset::BakeParts,
    ray::{EightRays, Intersector, RayDevices},
    scene::Mesh,
    sphere::fibonacci_directions,
    threads::CoreClock,
};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Directions of the pilot visibility; the error of an edge is known to about 1 / √128. Pictures of drafts have the same errors
/// with 256, which take half as long again.
const DIRECTIONS: usize = 128;

/// Every how many of these directions is traced from midpoints of edges shorter than a unit, most edges of a dense mesh: what their ends do
/// not tell is known to about 1 / √32.
pub(super) const OF_SHORT: usize = 4;

/// Points of one piece of work for a device, between checks for cancellation.
const POINTS_PER_PIECE: usize = 8192;

/// Functions that vertices store, which must be linear along edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// Visibility of distant light.
    pub environment: bool,
    /// Light from surface sources.
    pub bounces: bool,
}

impl Stored {
    /// The functions of a bake, if vertices store any: those of a basis lie at points of their own. A basis beside them asks for the
    /// same vertices as sources do, so that parts are the same with any others.
    pub fn of(mode: BakeParts) -> Option<Self> {
        let stores = mode.environment() || mode.sources();
        stores.then(|| Self { environment: mode.environment(), bounces: mode.bounces() })
    }
}

/// Nearness of surfaces, along which their light varies over an edge: `1 / (1 + t / r)` for a distance `t`, where `r` is this many
/// units of the edge length. A surface much farther away hides other light equally from the whole edge. In the color box 8, 24 and
/// 64 units leave errors of 0.037, 0.032 and 0.035.
const HALF_DISTANCE: f32 = 24.0;

/// Visibility and nearness from single points over few directions.
pub(super) struct Pilot<'a> {
    scene: &'a Intersector,
    device: UntilFailure<'a, PilotDevice>,
    toward: Vec<Vec3>,
    stored: Stored,
    /// Distance in meters at which nearness is a half.
    half_distance: f32,
    /// Errors at the midpoints of edges by their welded ends, kept between rounds: most edges are not split.
    errors: FxHashMap<(u32, u32), f32>,
    /// Samples of vertices.
    samples: Vec<PilotSample>,
    /// Where the sample of a point is.
    places: FxHashMap<PointKey, u32>,
    /// Checked for cancellation before each point, because a round traces millions of rays, and informed of the traced points.
    observer: &'a dyn Observer,
    traced: &'a AtomicU64,
}

/// Visibility from a point in each direction.
#[derive(Clone)]
struct PilotSample {
    /// Whether distant light arrives, one bit per direction.
    open: [u64; DIRECTIONS / 64],
    /// Nearness of a surface as a fraction of 255, if light from surfaces is stored.
    nearness: Option<Box<[u8; DIRECTIONS]>>,
}

/// Position, normal and sides of a point. Its offset and horizon change slightly as adjacent triangles are split; its sample is
/// kept anyway.
type PointKey = ([u32; 3], [u32; 3], bool);

fn key_of(point: &BakePoint) -> PointKey {
    (exact_key(point.position), exact_key(point.normal), point.two_sided)
}

impl<'a> Pilot<'a> {
    /// `unit` is the edge length of equal triangles, in meters.
    pub fn new(
        (scene, devices): (&'a Intersector, Option<&dyn RayDevices>),
        stored: Stored,
        unit: f32,
        (observer, traced): (&'a dyn Observer, &'a AtomicU64),
    ) -> Self {
        let toward = fibonacci_directions(DIRECTIONS);
        let device = PilotDevice::new(devices, scene, stored.bounces, &toward);
        Self {
            scene,
            device: UntilFailure::new(device, observer),
            toward,
            stored,
            half_distance: HALF_DISTANCE * unit,
            errors: FxHashMap::default(),
            samples: Vec::new(),
            places: FxHashMap::default(),
            observer,
            traced,
        }
    }

    /// Samples of the points in order, in every `step`th direction.
    fn seen_from(&self, points: &[BakePoint], step: usize) -> Result<Vec<PilotSample>, BakeError> {
        let mut samples = Vec::with_capacity(points.len());
        let piece = self.device.get().map_or(points.len().max(1), |_| POINTS_PER_PIECE);
        for points in points.chunks(piece) {
            cancelled(self.observer)?;
            match self.device.run(|device| self.seen_by_device(device, points, step)) {
                Some(seen) => {
                    self.advance(points.len(), step);
                    samples.extend(seen);
                }
                None => samples.extend(self.seen_by_cores(points, step)?),
            }
        }
        Ok(samples)
    }

    /// Samples of points, with a fan of rays from each side.
    fn seen_by_device(
        &self,
        device: &PilotDevice,
        points: &[BakePoint],
        step: usize,
    ) -> Result<Vec<PilotSample>, String> {
        let origins = origins_of(points);
        let met = device.trace(&origins, step)?;
        let directions: Vec<(usize, Vec3)> = self.toward.iter().copied().enumerate().step_by(step).collect();
        let mut next = 0;
        let firsts = points.iter().map(|point| {
            next += point.sides().len();
            next - point.sides().len()
        });
        let sample = |(point, first): (&BakePoint, usize)| {
            let mut sample = self.nothing_seen();
            for (ray, &(direction, d)) in directions.iter().enumerate() {
                let facing = point.side_of(d);
                if let Some(side) = point.sides().iter().position(|&side| side == facing) {
                    let distance = met.distance(first + side, ray, directions.len());
                    self.see(&mut sample, direction, distance == f32::INFINITY, distance);
                }
            }
            sample
        };
        Ok(points.par_iter().zip(firsts.collect::<Vec<_>>()).map(sample).collect())
    }

    /// Samples of points by the cores. Neighbors are traced together, because their rays in one direction are close.
    fn seen_by_cores(&self, points: &[BakePoint], step: usize) -> Result<Vec<PilotSample>, BakeError> {
        let order = z_order(points);
        let eights = order.par_chunks(8).map(|members| {
            cancelled(self.observer)?;
            let eight: Vec<&BakePoint> = members.iter().map(|&i| &points[i as usize]).collect();
            let seen = members.iter().copied().zip(self.seen_from_eight(&eight, step)).collect::<Vec<_>>();
            self.advance(members.len(), step);
            Ok(seen)
        });
        let eights = eights.collect::<Result<Vec<_>, BakeError>>()?;
        let mut samples: Vec<(u32, PilotSample)> = eights.into_iter().flatten().collect();
        samples.par_sort_unstable_by_key(|(index, _)| *index);
        Ok(samples.into_iter().map(|(_, sample)| sample).collect())
    }

    /// Tells of points that were traced in every `step`th direction.
    fn advance(&self, points: usize, step: usize) {
        let traced = points.div_ceil(step) as u64;
        self.observer.event(Event::Advanced { done: self.traced.fetch_add(traced, Ordering::Relaxed) + traced });
    }

    /// Samples of one to eight points, in every `step`th direction.
    fn seen_from_eight(&self, points: &[&BakePoint], step: usize) -> Vec<PilotSample> {
        let rays: Vec<EightRays> = self.toward.iter().step_by(step).map(|&d| rays_in_direction(points, d)).collect();
        let mut seen = vec![self.nothing_seen(); points.len()];
        let open = self.scene.mostly_open(&rays);
        // Nearness alone needs distances.
        let distances = if self.stored.bounces { self.scene.closest_distances(&rays) } else { Vec::new() };
        for (i, (rays, open)) in rays.iter().zip(open).enumerate() {
            for (lane, sample) in seen.iter_mut().enumerate().filter(|(lane, _)| rays.active() >> lane & 1 == 1) {
                let distance = distances.get(i).map_or(0.0, |of| of[lane]);
                self.see(sample, step * i, open >> lane & 1 == 1, distance);
            }
        }
        seen
    }

    /// The sample of a point before any ray.
    fn nothing_seen(&self) -> PilotSample {
        let nearness = self.stored.bounces.then(|| Box::new([0; DIRECTIONS]));
        PilotSample { open: [0; DIRECTIONS / 64], nearness }
    }

    /// Records a ray, with the distance in meters of what it meets if light from surfaces is stored.
    fn see(&self, sample: &mut PilotSample, direction: usize, is_open: bool, distance: f32) {
        if is_open && self.stored.environment {
            sample.open[direction / 64] |= 1 << (direction % 64);
        }
        if let Some(nearness) = &mut sample.nearness {
            // Zero at an infinite distance.
            nearness[direction] = (255.0 / (1.0 + distance / self.half_distance)) as u8;
        }
    }

    /// Traces some points, which are known from then on.
    fn learn(&mut self, points: Vec<BakePoint>) -> Result<(), BakeError> {
        let (first, samples) = (self.samples.len() as u32, self.seen_from(&points, 1)?);
        self.samples.extend(samples);
        self.places.extend(points.iter().map(key_of).zip(first..));
        Ok(())
    }

    /// Errors of linear interpolation at the midpoints of edges, by their lengths in units. Traces what it does not know.
    pub fn errors(
        &mut self,
        mesh: &Mesh,
        sides: &Sidedness,
        edges: &Edges,
        candidates: &[u32],
        length: impl Fn(u32) -> f32,
    ) -> Result<Vec<f32>, BakeError> {
        let known = |&e: &u32| self.errors.get(&edges.ends[e as usize]).copied();
        let mut errors: Vec<Option<f32>> = candidates.par_iter().map(known).collect();
        let unknown = candidates.iter().zip(&errors).filter(|(_, error)| error.is_none()).map(|(&e, _)| e);
        let (short, long): (Vec<u32>, Vec<u32>) = unknown.partition(|&e| length(e) < 1.0);
        let points = BakePoints::new(mesh, sides);
        for (unknown, step) in [(short, OF_SHORT), (long, 1)] {
            let found = self.learn_errors((mesh, edges, &points), &unknown, step)?;
            self.errors.extend(unknown.iter().map(|&e| edges.ends[e as usize]).zip(found));
        }
        let learn = |(error, &e): (&mut Option<f32>, &u32)| {
            *error = error.or_else(|| self.errors.get(&edges.ends[e as usize]).copied());
        };
        errors.par_iter_mut().zip(candidates).for_each(learn);
        Ok(errors.into_iter().flatten().collect())
    }

    /// Traces the ends of edges, and their midpoints in every `step`th direction.
    fn learn_errors(
        &mut self,
        (mesh, edges, points): (&Mesh, &Edges, &BakePoints),
        unknown: &[u32],
        step: usize,
    ) -> Result<Vec<f32>, BakeError> {
        let ends_of = |&e: &u32| end_vertices(mesh, edges, e).map(|v| points.of_vertex[v as usize]);
        let ends: Vec<[u32; 2]> = unknown.par_iter().map(ends_of).collect();
        let mut needed: Vec<u32> = ends.iter().copied().flatten().collect();
        needed.par_sort_unstable();
        needed.dedup();
        let needed = needed.par_iter().map(|&p| points.points[p as usize]);
        self.learn(needed.filter(|point| !self.places.contains_key(&key_of(point))).collect())?;
        let middle = |ends: &[u32; 2]| {
            let [a, b] = ends.map(|p| &points.points[p as usize]);
            midpoint(a, b)
        };
        let middles = self.seen_from(&ends.par_iter().map(middle).collect::<Vec<_>>(), step)?;
        let sample_of = |p: u32| &self.samples[self.places[&key_of(&points.points[p as usize])] as usize];
        let error = |(ends, middle): (&[u32; 2], &PilotSample)| {
            let [a, b] = ends.map(sample_of);
            midpoint_error((middle, step), a, b)
        };
        Ok(ends.par_iter().zip(&middles).map(error).collect())
    }
}

/// Core seconds for sampling points by the pilot, on a pool of one thread.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn trace_seconds(
    scene: &Intersector,
    stored: Stored,
    points: &[BakePoint],
    observer: &dyn Observer,
) -> Result<f64, BakeError> {
    let traced = AtomicU64::new(0);
    let pilot = Pilot::new((scene, None), stored, 1.0, (observer, &traced));
    let start = CoreClock::begin();
    pilot.seen_from(points, 1)?;
    Ok(start.secs())
}

/// Rays of one to eight points in one direction, each from the side that faces it.
fn rays_in_direction(points: &[&BakePoint], direction: Vec3) -> EightRays {
    let (mut origins, mut active) = ([points[0].position; 8], 0);
    for (lane, point) in points.iter().enumerate() {
        let side = point.side_of(direction);
        if point.sides().contains(&side) {
            origins[lane] = point.origin(side);
            active |= 1 << lane;
        }
    }
    EightRays::new(origins, [direction; 8], active)
}

fn midpoint(a: &BakePoint, b: &BakePoint) -> BakePoint {
    let position = 0.5 * (a.position + b.position);
    BakePoint {
        position,
        places: [position; 2],
        normal: (a.normal + b.normal).try_normalize().unwrap_or(a.normal),
        offset: a.offset.min(b.offset),
        horizon: a.horizon.min(b.horizon),
        two_sided: a.two_sided,
    }
}

/// Mean over directions of the difference between the midpoint and the mean of the ends, for visibility or nearness, whichever is
/// larger. The midpoint is known in every `step`th direction.
fn midpoint_error((middle, step): (&PilotSample, usize), a: &PilotSample, b: &PilotSample) -> f32 {
    let traced = (0..64).step_by(step).fold(0_u64, |traced, bit| traced | 1 << bit);
    let words = (0..middle.open.len()).map(|i| (middle.open[i], a.open[i], b.open[i]));
    // Where the ends differ, the midpoint is wrong by one half either way.
    let halves =
        words.map(|(m, a, b)| (a ^ b).count_ones() + 2 * step as u32 * (!(a ^ b) & (a ^ m) & traced).count_ones());
    let open = halves.sum::<u32>() as f32 / (2 * DIRECTIONS) as f32;
    let [Some(middle), Some(a), Some(b)] = [middle, a, b].map(|sample| sample.nearness.as_ref()) else { return open };
    let twice = |i: usize| (2 * u32::from(middle[i])).abs_diff(u32::from(a[i]) + u32::from(b[i]));
    let traced = (0..DIRECTIONS).step_by(step);
    let nearness = traced.map(twice).sum::<u32>() as f32 / (2 * 255 * DIRECTIONS / step) as f32;
    open.max(nearness)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(open: u64, nearness: u8) -> PilotSample {
        PilotSample { open: [open; DIRECTIONS / 64], nearness: Some(Box::new([nearness; DIRECTIONS])) }
    }

    /// Of a short edge.
    fn error(middle: &PilotSample, a: &PilotSample, b: &PilotSample) -> f32 {
        midpoint_error((middle, OF_SHORT), a, b)
    }

    #[test]
    fn errors_at_midpoints_are_those_of_all_directions() {
        let (closed, open) = (sample(0, 0), sample(u64::MAX, 0));
        assert_eq!(error(&open, &closed, &closed), 1.0, "a thing between the ends hides all");
        assert_eq!(error(&closed, &closed, &open), 0.5, "either way");
        assert_eq!(error(&open, &open, &open), 0.0);
        let near = sample(0, 255);
        assert_eq!(error(&near, &closed, &closed), 1.0);
        assert_eq!(error(&closed, &near, &closed), 0.5);
        // Every direction that is traced from midpoints stands for as many.
        assert_eq!(error(&sample(1, 0), &closed, &closed), (2 * OF_SHORT) as f32 / DIRECTIONS as f32);
        assert_eq!(error(&sample(2, 0), &closed, &closed), 0.0, "negative control: it is not traced");
        assert_eq!(
            midpoint_error((&sample(2, 0), 1), &closed, &closed),
            2.0 / DIRECTIONS as f32,
            "that of a long edge"
        );
    }
}
