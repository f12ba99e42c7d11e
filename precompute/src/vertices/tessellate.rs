//! Tessellation where visibility varies, by conforming longest-edge bisection (Rivara 1984).
//!
//! Cuts are interpolated linearly inside triangles, so vertices are needed where visibility changes: without them a floor of two
//! triangles has no shadow. An edge is split if it is long for the vertex budget, or if linear interpolation is wrong at its
//! midpoint, for pilot visibility or, for bounced light, for the nearness of other surfaces. A triangle with an edge to split also
//! splits its longest edge, which bounds angles from below. Edges are identified by position, so seams of normals and texture
//! coordinates do not crack.

mod edges;
mod pilot;
mod pilot_device;
mod scale;
mod split;

use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    vertices::sidedness::Sidedness,
};
use edges::Edges;
use lapidary_core::{
    bounds::Bounds,
    ray::{Intersector, RayDevices},
    scene::Mesh,
    shot::Shot,
};
use pilot::Pilot;
pub use pilot::{Stored, trace_seconds};
use rayon::prelude::*;
use scale::EdgeScale;
use split::split_edges;
use std::sync::atomic::AtomicU64;

/// Error at an edge's midpoint above which the edge is split: the wrong part of the sphere, or the error of nearness.
const TOLERANCE: f32 = 0.01;
/// Edges longer than the first value are always split, shorter than the second never. The unit is the edge length at which equal
/// triangles over the whole surface, or over the pictures, would use up the budget; see `scale.rs`.
const LONGEST: f32 = 6.0;
const SHORTEST: f32 = 0.25;
/// Rounds of splitting; each at most halves all edges.
const ROUNDS: usize = 16;
/// Share of the remaining vertices that a round may add, except the last: halves of urgent edges may be more urgent than all
/// remaining edges. When the first round could add all of them, a picture on the living room's wall stayed black.
const SHARE_PER_ROUND: f32 = 0.3;

/// Approximate number of pilot points per vertex.
pub const POINTS_PER_VERTEX: u64 = 2;

/// The purpose of the vertices.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Functions that they store; `None` splits only long edges, without a pilot.
    pub stored: Option<Stored>,
    /// Largest number of vertices.
    pub budget: usize,
    /// Pictures for which most vertices are placed, if any.
    pub shots: &'a [Shot],
    /// Bounds of the scene, for the ground around it: density falls with distance.
    pub around: Option<Bounds>,
    /// Devices that trace the pilot's rays instead of the cores. Results differ only for rays along edges.
    pub devices: Option<&'a dyn RayDevices>,
    /// Counts the points that the pilot has traced.
    pub traced: &'a AtomicU64,
}

/// Splits edges of `mesh` until the vertex budget is used up, or the stored functions are linear enough. `sides` keeps one entry
/// per triangle.
///
/// # Errors
/// [`BakeError::Cancelled`], within one point's tracing after the observer's request.
pub fn tessellate(
    mesh: &mut Mesh,
    sides: &mut Sidedness,
    scene: &Intersector,
    wanted: Wanted,
    observer: &dyn Observer,
) -> Result<(), BakeError> {
    let Wanted { stored, budget, devices, traced, .. } = wanted;
    if mesh.positions.len() >= budget {
        return Ok(());
    }
    let scale = EdgeScale::new(mesh, scene, wanted, observer);
    let mut pilot = stored.map(|stored| Pilot::new((scene, devices), stored, scale.unit, (observer, traced)));
    for round in 1..=ROUNDS {
        cancelled(observer)?;
        let left = budget.saturating_sub(mesh.positions.len());
        if left == 0 {
            break;
        }
        let edges = Edges::new(mesh);
        let wanted = wanted_edges(mesh, sides, &edges, pilot.as_mut(), &scale)?;
        let part = if round < ROUNDS { (SHARE_PER_ROUND * left as f32) as usize } else { left };
        let mut chosen = edges.within_budget(&wanted, part);
        if chosen.is_empty() {
            chosen = edges.within_budget(&wanted, left);
        }
        cancelled(observer)?;
        if chosen.is_empty() {
            break;
        }
        split_edges(mesh, sides, &edges, &chosen);
        if pilot.is_none() {
            observer.event(Event::Advanced { done: POINTS_PER_VERTEX * mesh.positions.len() as u64 });
        }
    }
    Ok(())
}

/// Edges to split, the most urgent first.
fn wanted_edges(
    mesh: &Mesh,
    sides: &Sidedness,
    edges: &Edges,
    pilot: Option<&mut Pilot>,
    scale: &EdgeScale,
) -> Result<Vec<u32>, BakeError> {
    let of_triangles = scale.of_triangles(mesh)?;
    let length = |e: u32| {
        let scale = edges.triangles(e).iter().map(|&t| of_triangles[t as usize]).fold(0.0, f32::max);
        edges.length_sq[e as usize].sqrt() * scale
    };
    let lengths: Vec<f32> = (0..edges.ends.len() as u32).into_par_iter().map(length).collect();
    let length = |e: u32| lengths[e as usize];
    let (long, candidates): (Vec<u32>, Vec<u32>) =
        (0..edges.ends.len() as u32).filter(|&e| length(e) > SHORTEST).partition(|&e| length(e) > LONGEST);
    // Long edges come first, by length. Then come edges with visible errors, by affected area.
    let mut ranked: Vec<(f32, u32)> = long.into_iter().map(|e| (1e3 + length(e), e)).collect();
    if let Some(pilot) = pilot {
        let errors = pilot.errors(mesh, sides, edges, &candidates, length)?;
        let visible = candidates.par_iter().zip(errors).filter(|(_, error)| *error > TOLERANCE);
        ranked.par_extend(visible.map(|(&e, error)| (error * length(e).powi(2), e)));
    }
    ranked.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    Ok(ranked.into_iter().map(|r| r.1).collect())
}

#[cfg(test)]
mod tests;
