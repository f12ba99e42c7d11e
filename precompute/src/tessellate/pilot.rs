//! How wrong linear interpolation of visibility would be at the middle of an edge.

use super::edges::{EdgeKey, Edges, end_vertices};
use crate::{
    BakeError,
    bake::cancelled,
    bake_points::{BakePoint, BakePoints},
    observer::Observer,
    sidedness::Sidedness,
};
use lapidary_core::{
    ray::{DirectionSet, Intersector},
    scene::Mesh,
    sphere::fibonacci_directions,
};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// Directions of the pilot visibility; the error of an edge is known to about 1 / √256.
const DIRECTIONS: usize = 256;

/// Visibility from single points over few directions.
pub(super) struct Pilot<'a> {
    scene: &'a Intersector,
    directions: DirectionSet,
    /// Errors at the midpoints of edges, kept from round to round: most edges stay whole.
    pub errors: HashMap<EdgeKey, f32>,
    /// Asked before each point whether to go on: a round traces millions of rays.
    observer: &'a dyn Observer,
}

type Seen = [u8; DIRECTIONS];

impl<'a> Pilot<'a> {
    pub fn new(scene: &'a Intersector, observer: &'a dyn Observer) -> Self {
        let directions = DirectionSet::new(&fibonacci_directions(DIRECTIONS));
        Self { scene, directions, errors: HashMap::new(), observer }
    }

    fn seen(&self, point: &BakePoint) -> Result<Seen, BakeError> {
        cancelled(self.observer)?;
        let mut visible = [0; DIRECTIONS];
        self.scene.trace_batch(point.origin(true), &self.directions, |d| point.is_upper(d), &mut visible);
        if point.two_sided {
            self.scene.trace_batch(point.origin(false), &self.directions, |d| !point.is_upper(d), &mut visible);
        }
        Ok(visible)
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
        let needed: HashSet<u32> = unknown.iter().flat_map(|&e| ends(e)).collect();
        let seen_from = |p: u32| Ok((p, self.seen(&points.points[p as usize])?));
        let seen = needed.into_par_iter().map(seen_from).collect::<Result<HashMap<u32, Seen>, BakeError>>()?;
        let error = |&e: &u32| {
            let [a, b] = ends(e);
            let middle = self.seen(&midpoint(&points.points[a as usize], &points.points[b as usize]))?;
            Ok((edges.key(mesh, e), midpoint_error(&middle, &seen[&a], &seen[&b])))
        };
        let found = unknown.par_iter().map(error).collect::<Result<Vec<(EdgeKey, f32)>, BakeError>>()?;
        self.errors.extend(found);
        Ok(())
    }
}

fn midpoint(a: &BakePoint, b: &BakePoint) -> BakePoint {
    BakePoint {
        position: 0.5 * (a.position + b.position),
        normal: (a.normal + b.normal).try_normalize().unwrap_or(a.normal),
        offset: a.offset.min(b.offset),
        horizon: a.horizon.min(b.horizon),
        two_sided: a.two_sided,
        radius: 0.5 * a.radius.min(b.radius),
    }
}

/// Mean over directions of how far the midpoint is from the mean of the ends.
fn midpoint_error(middle: &Seen, a: &Seen, b: &Seen) -> f32 {
    let twice: u32 = (0..DIRECTIONS).map(|i| u32::from((2 * middle[i]).abs_diff(a[i] + b[i]))).sum();
    twice as f32 / (2 * DIRECTIONS) as f32
}
