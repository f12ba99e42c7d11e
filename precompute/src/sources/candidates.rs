//! Candidates: where importance particles land that are traced backwards from a valid viewpoint.
//!
//! A particle reflects about with cosine-distributed directions, up to [`BOUNCES`] times; the first [`DROPPED`] landings
//! do not count, so that the density does not depend on where the viewpoint is. Where most particles escape before that, as
//! over an open plane, all landings count.
//!
//! Where pictures are given, most candidates are what lights these: ends of flights from the surfaces that they show.

use crate::{errors::PointsError, observer::Observer};
use glam::{Vec2, Vec3};
use lapidary_core::{
    shot::Shot,
    sphere::{cosine_direction, fibonacci_directions, frame_around, uniform_direction},
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Landings of a particle (the paper's 30).
const BOUNCES: usize = 30;
/// The first of them that do not count (the paper's 3).
const DROPPED: usize = 3;
/// Rays that tell whether anything is seen from a viewpoint.
const RAYS_OF_CHECK: usize = 256;
/// Particles that tell what share of them lands how often.
const FIRST: u64 = 256;
/// Particles traced at a time: enough that no core waits long for the others.
const BATCH: u64 = 4096;
/// Batches without a landing after which there are no more candidates.
const EMPTY_BATCHES: usize = 16;
/// Share of particles that must land more than [`DROPPED`] times for these to be dropped.
const ENOUGH: f64 = 0.1;
/// Candidates that pictures have for each other one: four fifths are theirs.
const PICTURED: usize = 4;
/// Rows of a picture among whose places flights are spread; any number would do.
const ROWS: f32 = 1024.0;

/// An endless supply of points on surfaces from which light reaches the viewpoint; the same ones for the same seed.
pub struct Candidates<'a> {
    surface: &'a dyn Surface,
    observer: &'a dyn Observer,
    viewpoint: Vec3,
    seed: u64,
    dropped: usize,
    shots: &'a [Shot],
    next_particle: u64,
    ready: VecDeque<Flight>,
}

impl<'a> Candidates<'a> {
    /// From a viewpoint that is checked here.
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
        let paths: Vec<_> = (0..FIRST).into_par_iter().map(|p| candidates.particle(p).len()).collect();
        let long = paths.iter().filter(|&&length| length > DROPPED).count();
        candidates.dropped = if long as f64 >= ENOUGH * FIRST as f64 { DROPPED } else { 0 };
        Ok(candidates)
    }

    /// With most of the candidates where light comes from that the shots see.
    pub fn for_shots(self, shots: &'a [Shot]) -> Self {
        Self { shots, ..self }
    }

    /// The next candidate. `None` if particles land nowhere any more.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub fn draw(&mut self) -> Result<Option<Surfel>, PointsError> {
        Ok(self.draw_flight()?.map(|flight| flight.end))
    }

    /// [`Self::draw`], and how long the flight was that ends there.
    pub(super) fn draw_flight(&mut self) -> Result<Option<Flight>, PointsError> {
        for _ in 0..EMPTY_BATCHES {
            if let Some(candidate) = self.ready.pop_front() {
                return Ok(Some(candidate));
            }
            if self.observer.cancelled() {
                return Err(PointsError::Cancelled);
            }
            let particles = self.next_particle..self.next_particle + BATCH;
            self.next_particle = particles.end;
            let landed: Vec<Vec<Flight>> = particles.into_par_iter().map(|p| self.flights(p)).collect();
            self.ready.extend(landed.into_iter().flatten());
        }
        Ok(self.ready.pop_front())
    }

    /// At least `count` flights of particles whatever the pictures, spread evenly over the surface; fewer if they escape.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub(super) fn strays(&self, count: usize) -> Result<Vec<Flight>, PointsError> {
        if self.observer.cancelled() {
            return Err(PointsError::Cancelled);
        }
        let particles = (count / (BOUNCES - DROPPED)) as u64 + FIRST;
        Ok((0..particles).into_par_iter().flat_map_iter(|p| self.particle(p)).collect())
    }

    pub(super) fn surface(&self) -> &'a dyn Surface {
        self.surface
    }

    /// Those of a particle, and [`PICTURED`] times as many from what the shots see.
    fn flights(&self, index: u64) -> Vec<Flight> {
        let mut flights = self.particle(index);
        if !self.shots.is_empty() {
            let mut rng = fastrand::Rng::with_seed(!self.seed ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let wanted = PICTURED * flights.len();
            flights.extend((0..wanted).filter_map(|_| self.flight_in_picture(&mut rng)));
        }
        flights
    }

    /// Where a particle flies.
    fn particle(&self, index: u64) -> Vec<Flight> {
        let mut rng = fastrand::Rng::with_seed(self.seed ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let direction = uniform_direction(rng.f32(), rng.f32());
        flights(self.surface, self.viewpoint, direction, BOUNCES, &mut rng).skip(self.dropped).collect()
    }

    /// From a random place of one of the pictures, cosine-distributed about its normal.
    fn flight_in_picture(&self, rng: &mut fastrand::Rng) -> Option<Flight> {
        let Shot { camera, aspect } = &self.shots[rng.usize(0..self.shots.len())];
        let size = [(ROWS * aspect).ceil().max(1.0) as u32, ROWS as u32];
        let pixel = Vec2::new(rng.f32() * size[0] as f32, rng.f32() * size[1] as f32);
        flights(self.surface, camera.eye, camera.direction_through(pixel, size), 2, rng).nth(1)
    }
}

/// Whether particles from a viewpoint land at all.
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

/// A straight way of a particle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Where it lands.
    pub end: Surfel,
    /// How long the way was, in metres.
    pub flown: f32,
}

/// Where a particle lands that is sent along a direction and reflected about, at most `most` times.
pub(super) fn landings<'a>(
    surface: &'a dyn Surface,
    origin: Vec3,
    direction: Vec3,
    most: usize,
    rng: &'a mut fastrand::Rng,
) -> impl Iterator<Item = Surfel> + 'a {
    flights(surface, origin, direction, most, rng).map(|flight| flight.end)
}

fn flights<'a>(
    surface: &'a dyn Surface,
    mut origin: Vec3,
    mut direction: Vec3,
    most: usize,
    rng: &'a mut fastrand::Rng,
) -> impl Iterator<Item = Flight> + 'a {
    let offset = surface.offset();
    let next = move || {
        let hit = surface.first_hit(origin, direction)?;
        let flown = hit.position.distance(origin);
        origin = step_back(origin, direction, &hit, offset);
        direction = frame_around(hit.normal) * cosine_direction(rng.f32(), rng.f32());
        Some(Flight { end: hit, flown })
    };
    std::iter::from_fn(next).take(most)
}

/// A place off the surface on the way that the particle came: nothing lies there, even in a corner where a step along the
/// normal could pass through the wall beside.
fn step_back(origin: Vec3, direction: Vec3, hit: &Surfel, offset: f32) -> Vec3 {
    let cosine = direction.dot(hit.normal).abs().max(1e-3);
    hit.position - direction * (offset / cosine).min(0.5 * origin.distance(hit.position))
}
