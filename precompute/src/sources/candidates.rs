//! Candidates: hits of importance particles traced from a valid viewpoint.
//!
//! A particle is reflected in cosine-distributed directions, up to [`BOUNCES`] times. Its first [`DROPPED_HITS`] hits do not count,
//! so that the density is independent of the viewpoint. If most particles escape before that, as over an open plane, all hits
//! count.
//!
//! If shots are given, most candidates lie on surfaces that light them: they are ends of segments from the surfaces in the
//! pictures.

use crate::{errors::PointsError, observer::Observer};
use glam::{Vec2, Vec3};
use lapidary_core::{
    shot::Shot,
    sphere::{cosine_direction, fibonacci_directions, frame_around, uniform_direction},
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Hits of a particle (30 in the paper).
const BOUNCES: usize = 30;
/// First hits that do not count (3 in the paper).
const DROPPED_HITS: usize = 3;
/// Rays that check whether a viewpoint sees anything.
const RAYS_OF_CHECK: usize = 256;
/// Particles that measure how often particles hit before they escape.
const PROBES: u64 = 256;
/// Particles traced at a time: enough to keep all cores busy.
const BATCH: u64 = 4096;
/// Batches without a hit after which there are no more candidates.
const EMPTY_BATCHES: usize = 16;
/// Share of particles that must hit more than [`DROPPED_HITS`] times for these hits to be dropped.
const LEAST_SHARE_OF_LONG_PATHS: f64 = 0.1;
/// Candidates from pictures for each other candidate: four fifths come from pictures.
const PICTURED_PER_OTHER: usize = 4;
/// Rows of a picture over which segments are spread; any number would do.
const ROWS: f32 = 1024.0;

/// An endless supply of points on surfaces from which light reaches the viewpoint; equal seeds give equal points.
pub struct Candidates<'a> {
    surface: &'a dyn Surface,
    observer: &'a dyn Observer,
    viewpoint: Vec3,
    seed: u64,
    dropped: usize,
    shots: &'a [Shot],
    next_particle: u64,
    ready: VecDeque<Segment>,
}

impl<'a> Candidates<'a> {
    /// Checks the viewpoint and starts at it.
    ///
    /// # Errors
    /// [`PointsError::SeesNothing`].
    pub fn new(
        surface: &'a dyn Surface,
        viewpoint: Vec3,
        seed: u64,
        observer: &'a dyn Observer,
    ) -> Result<Self, PointsError> {
        check_viewpoint(surface, viewpoint)?;
        let ready = VecDeque::new();
        let mut candidates =
            Self { surface, observer, viewpoint, seed, dropped: 0, shots: &[], next_particle: 0, ready };
        let paths: Vec<_> = (0..PROBES).into_par_iter().map(|p| candidates.particle(p).len()).collect();
        let long = paths.iter().filter(|&&length| length > DROPPED_HITS).count();
        candidates.dropped = if long as f64 >= LEAST_SHARE_OF_LONG_PATHS * PROBES as f64 { DROPPED_HITS } else { 0 };
        Ok(candidates)
    }

    /// Takes most candidates from surfaces that light the shots' pictures.
    pub fn for_shots(self, shots: &'a [Shot]) -> Self {
        Self { shots, ..self }
    }

    /// The next candidate. `None` if particles no longer hit anything.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub fn draw(&mut self) -> Result<Option<Surfel>, PointsError> {
        Ok(self.draw_segment()?.map(|segment| segment.end))
    }

    /// [`Self::draw`] with the length of the segment that ends there.
    pub(super) fn draw_segment(&mut self) -> Result<Option<Segment>, PointsError> {
        for _ in 0..EMPTY_BATCHES {
            if let Some(candidate) = self.ready.pop_front() {
                return Ok(Some(candidate));
            }
            if self.observer.cancelled() {
                return Err(PointsError::Cancelled);
            }
            let particles = self.next_particle..self.next_particle + BATCH;
            self.next_particle = particles.end;
            let segments: Vec<Vec<Segment>> = particles.into_par_iter().map(|p| self.segments(p)).collect();
            self.ready.extend(segments.into_iter().flatten());
        }
        Ok(self.ready.pop_front())
    }

    /// At least `count` segments of particles, ignoring shots, spread evenly over the surface; fewer if particles escape.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub(super) fn particle_segments(&self, count: usize) -> Result<Vec<Segment>, PointsError> {
        if self.observer.cancelled() {
            return Err(PointsError::Cancelled);
        }
        let particles = (count / (BOUNCES - DROPPED_HITS)) as u64 + PROBES;
        Ok((0..particles).into_par_iter().flat_map_iter(|p| self.particle(p)).collect())
    }

    pub(super) fn surface(&self) -> &'a dyn Surface {
        self.surface
    }

    /// Observer of the progress.
    pub(super) fn observer(&self) -> &'a dyn Observer {
        self.observer
    }

    /// The segments of a particle, and [`PICTURED_PER_OTHER`] times as many from surfaces in the shots.
    fn segments(&self, index: u64) -> Vec<Segment> {
        let mut segments = self.particle(index);
        if !self.shots.is_empty() {
            let mut rng = fastrand::Rng::with_seed(!self.seed ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let wanted = PICTURED_PER_OTHER * segments.len();
            segments.extend((0..wanted).filter_map(|_| self.segment_in_picture(&mut rng)));
        }
        segments
    }

    /// The segments of a particle's path.
    fn particle(&self, index: u64) -> Vec<Segment> {
        let mut rng = fastrand::Rng::with_seed(self.seed ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let direction = uniform_direction(rng.f32(), rng.f32());
        segments(self.surface, self.viewpoint, direction, BOUNCES, &mut rng).skip(self.dropped).collect()
    }

    /// A segment from a random point in one of the pictures, cosine-distributed about its normal.
    fn segment_in_picture(&self, rng: &mut fastrand::Rng) -> Option<Segment> {
        let Shot { camera, aspect } = &self.shots[rng.usize(0..self.shots.len())];
        let size = [(ROWS * aspect).ceil().max(1.0) as u32, ROWS as u32];
        let pixel = Vec2::new(rng.f32() * size[0] as f32, rng.f32() * size[1] as f32);
        let (origin, direction) = camera.projection(size).ray(pixel);
        segments(self.surface, origin, direction, 2, rng).nth(1)
    }
}

/// Checks that particles from a viewpoint hit anything.
///
/// # Errors
/// [`PointsError::SeesNothing`].
pub fn check_viewpoint(surface: &dyn Surface, viewpoint: Vec3) -> Result<(), PointsError> {
    let sees = |&d: &Vec3| surface.first_hit(viewpoint, d).is_some();
    if viewpoint.is_finite() && fibonacci_directions(RAYS_OF_CHECK).iter().any(sees) {
        Ok(())
    } else {
        Err(PointsError::SeesNothing(viewpoint))
    }
}

/// A segment of a particle's path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Its hit.
    pub end: Surfel,
    /// Its length in meters.
    pub length: f32,
}

/// Hits of a particle that starts in a direction and is reflected at most `most` times.
pub(super) fn particle_hits<'a>(
    surface: &'a dyn Surface,
    origin: Vec3,
    direction: Vec3,
    most: usize,
    rng: &'a mut fastrand::Rng,
) -> impl Iterator<Item = Surfel> + 'a {
    segments(surface, origin, direction, most, rng).map(|segment| segment.end)
}

fn segments<'a>(
    surface: &'a dyn Surface,
    mut origin: Vec3,
    mut direction: Vec3,
    most: usize,
    rng: &'a mut fastrand::Rng,
) -> impl Iterator<Item = Segment> + 'a {
    let offset = surface.offset();
    let next = move || {
        let hit = surface.first_hit(origin, direction)?;
        let length = hit.position.distance(origin);
        origin = step_back(origin, direction, &hit, offset);
        direction = frame_around(hit.normal) * cosine_direction(rng.f32(), rng.f32());
        Some(Segment { end: hit, length })
    };
    std::iter::from_fn(next).take(most)
}

/// A point slightly back along the particle's path. That space is free even in a corner, where a step along the normal could pass
/// through the adjacent wall.
fn step_back(origin: Vec3, direction: Vec3, hit: &Surfel, offset: f32) -> Vec3 {
    let cosine = direction.dot(hit.normal).abs().max(1e-3);
    hit.position - direction * (offset / cosine).min(0.5 * origin.distance(hit.position))
}
