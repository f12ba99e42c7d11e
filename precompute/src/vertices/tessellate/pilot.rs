//! Error of linear interpolation of visibility at the middle of an edge.

use super::edges::{EdgeKey, Edges, end_vertices};
use crate::{
    errors::{BakeError, cancelled},
    observer::Observer,
    vertices::{
        points::{BakePoint, BakePoints},
        sidedness::Sidedness,
        z_order::z_order,
    },
};
use glam::Vec3;
use lapidary_core::{
    ray::{EightRays, Intersector},
    scene::Mesh,
    sphere::fibonacci_directions,
};
use rayon::prelude::*;
use std::collections::HashMap;

/// Directions of the pilot visibility; the error of an edge is known to about 1 / √256.
const DIRECTIONS: usize = 256;

/// The functions that vertices store, which must therefore be linear along edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// Visibility of distant light.
    pub environment: bool,
    /// Light from surfaces.
    pub bounces: bool,
}

/// Light from surfaces changes along an edge as their nearness does: `1 / (1 + t / r)` for a distance `t`, where `r` is
/// this many units of the edge length. A surface at a much larger distance hides other light from the whole edge alike.
/// In the colour box 8, 24 and 64 units leave errors of 0.037, 0.032 and 0.035.
const HALF_DISTANCE: f32 = 24.0;

/// Visibility and nearness from single points over few directions.
pub(super) struct Pilot<'a> {
    scene: &'a Intersector,
    toward: Vec<Vec3>,
    stored: Stored,
    /// Distance in metres at which nearness is a half.
    half_distance: f32,
    /// Errors at the midpoints of edges, kept between rounds: most edges are not split.
    pub errors: HashMap<EdgeKey, f32>,
    /// Asked before each point whether to continue: a round traces millions of rays.
    observer: &'a dyn Observer,
}

/// For each direction, as a fraction of 255: whether light arrives from far away, and the nearness of a surface.
#[derive(Clone)]
struct PilotSample {
    open: [u8; DIRECTIONS],
    nearness: [u8; DIRECTIONS],
}

impl<'a> Pilot<'a> {
    /// `unit` is the edge length in metres that equal triangles would have.
    pub fn new(scene: &'a Intersector, stored: Stored, unit: f32, observer: &'a dyn Observer) -> Self {
        let toward = fibonacci_directions(DIRECTIONS);
        Self { scene, toward, stored, half_distance: HALF_DISTANCE * unit, errors: HashMap::new(), observer }
    }

    /// Samples of the points, in their order. Neighbours are traced together: their rays in one direction lie side by side.
    fn seen_from(&self, points: &[BakePoint]) -> Result<Vec<PilotSample>, BakeError> {
        let order = z_order(points);
        let eights = order.par_chunks(8).map(|members| {
            cancelled(self.observer)?;
            let eight: Vec<&BakePoint> = members.iter().map(|&i| &points[i as usize]).collect();
            Ok(members.iter().copied().zip(self.seen_from_eight(&eight)).collect::<Vec<_>>())
        });
        let mut samples: Vec<(u32, PilotSample)> = eights.collect::<Result<Vec<_>, BakeError>>()?.concat();
        samples.sort_unstable_by_key(|(index, _)| *index);
        Ok(samples.into_iter().map(|(_, sample)| sample).collect())
    }

    /// Samples of one to eight points.
    fn seen_from_eight(&self, points: &[&BakePoint]) -> Vec<PilotSample> {
        let rays: Vec<EightRays> = self.toward.iter().map(|&d| rays_in_direction(points, d)).collect();
        let mut seen = vec![PilotSample { open: [0; DIRECTIONS], nearness: [0; DIRECTIONS] }; points.len()];
        if self.stored.bounces {
            for (i, (rays, distances)) in rays.iter().zip(self.scene.closest_distances(&rays)).enumerate() {
                for (lane, sample) in seen.iter_mut().enumerate().filter(|(lane, _)| rays.active() >> lane & 1 == 1) {
                    let distance = distances[lane];
                    sample.open[i] = u8::from(distance == f32::INFINITY && self.stored.environment) * u8::MAX;
                    // Zero at an infinite distance.
                    sample.nearness[i] = (255.0 / (1.0 + distance / self.half_distance)) as u8;
                }
            }
        } else {
            for (i, open) in self.scene.open(&rays).into_iter().enumerate() {
                for (lane, sample) in seen.iter_mut().enumerate() {
                    sample.open[i] = (open >> lane & 1) * u8::MAX;
                }
            }
        }
        seen
    }

    /// Traces the ends and midpoints of those edges whose error is not known yet.
    pub fn learn_errors(
        &mut self,
        mesh: &Mesh,
        sides: &Sidedness,
        edges: &Edges,
        candidates: &[u32],
    ) -> Result<(), BakeError> {
        let unknown: Vec<u32> =
            candidates.iter().copied().filter(|&e| !self.errors.contains_key(&edges.key(mesh, e))).collect();
        let points = BakePoints::new(mesh, sides);
        let ends = |e: u32| end_vertices(mesh, edges, e).map(|v| points.of_vertex[v as usize]);
        let mut needed: Vec<u32> = unknown.iter().flat_map(|&e| ends(e)).collect();
        needed.sort_unstable();
        needed.dedup();
        let of_ends = self.seen_from(&needed.iter().map(|&p| points.points[p as usize]).collect::<Vec<_>>())?;
        let middle = |&e: &u32| {
            let [a, b] = ends(e).map(|p| &points.points[p as usize]);
            midpoint(a, b)
        };
        let of_middles = self.seen_from(&unknown.par_iter().map(middle).collect::<Vec<_>>())?;
        let error = |(&e, middle): (&u32, &PilotSample)| {
            let [a, b] = ends(e).map(|p| &of_ends[needed.partition_point(|&known| known < p)]);
            (edges.key(mesh, e), midpoint_error(middle, a, b))
        };
        let found: Vec<(EdgeKey, f32)> = unknown.par_iter().zip(&of_middles).map(error).collect();
        self.errors.extend(found);
        Ok(())
    }
}

/// Rays of one to eight points in one direction, each from the side that samples it.
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

/// Mean over directions of the difference between the midpoint and the mean of the ends, for visibility or nearness,
/// whichever is larger.
fn midpoint_error(middle: &PilotSample, a: &PilotSample, b: &PilotSample) -> f32 {
    let mean = |of: fn(&PilotSample) -> &[u8; DIRECTIONS]| {
        let [middle, a, b] = [of(middle), of(a), of(b)].map(|values| values.map(u32::from));
        let twice: u32 = (0..DIRECTIONS).map(|i| (2 * middle[i]).abs_diff(a[i] + b[i])).sum();
        twice as f32 / (2 * 255 * DIRECTIONS) as f32
    };
    mean(|seen| &seen.open).max(mean(|seen| &seen.nearness))
}
