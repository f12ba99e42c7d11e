//! Tessellation where visibility varies, by conforming longest-edge bisection (Rivara 1984).
//!
//! Cuts are interpolated linearly inside triangles, so vertices are needed where visibility changes: without them a
//! floor of two triangles has no shadow. An edge is split if it is long for the vertex budget, or if at its midpoint the pilot
//! visibility, or for bounced light the nearness of other surfaces, differs from the mean of its ends; a triangle with an edge
//! to split also splits its longest edge, which keeps angles bounded. Edges are told apart by position, so that seams of
//! normals and texture coordinates do not crack.

mod edges;
mod pilot;
mod split;

use crate::{
    BakeError,
    bake::cancelled,
    observer::{Event, Observer},
    sidedness::Sidedness,
};
use edges::Edges;
use lapidary_core::{ray::Intersector, scene::Mesh};
use pilot::Pilot;
pub use pilot::Stored;
use split::split_edges;

/// Part of the sphere that must be wrong at an edge's midpoint for the edge to be split, or how wrong nearness must be.
const TOLERANCE: f32 = 0.01;
/// Longest edge that is never left whole, and shortest that is never split, in units of the edge length at which equal
/// triangles over the whole surface would use up the budget.
const LONGEST: f32 = 6.0;
const SHORTEST: f32 = 0.25;
/// Rounds of splitting; each at most halves all edges.
const ROUNDS: usize = 16;
/// Part of the vertices that are left that a round makes, but for the last: halves of urgent edges may be more urgent than
/// all that is left of others. With all of them in the first round a picture on the living room's wall stayed black.
const PART_A_ROUND: f32 = 0.3;

/// Splits edges of `mesh` until it has at most `budget` vertices or what vertices are to store is linear enough. `sides` keeps
/// one entry a triangle.
///
/// # Errors
/// [`BakeError::Cancelled`], within the tracing of a point after the observer asked for it.
pub fn tessellate(
    mesh: &mut Mesh,
    sides: &mut Sidedness,
    scene: &Intersector,
    stored: Stored,
    budget: usize,
    observer: &dyn Observer,
) -> Result<(), BakeError> {
    let area: f32 = (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).sum();
    let unit = (1.15 * area / budget.max(1) as f32).sqrt();
    let mut pilot = Pilot::new(scene, stored, unit, observer);
    for round in 1..=ROUNDS {
        cancelled(observer)?;
        let left = budget.saturating_sub(mesh.positions.len());
        if left == 0 {
            break;
        }
        let edges = Edges::new(mesh);
        let wanted = wanted_edges(mesh, sides, &edges, &mut pilot, unit)?;
        let part = if round < ROUNDS { (PART_A_ROUND * left as f32) as usize } else { left };
        let mut chosen = edges.within_budget(&wanted, part);
        if chosen.is_empty() {
            chosen = edges.within_budget(&wanted, left);
        }
        cancelled(observer)?;
        if chosen.is_empty() {
            break;
        }
        split_edges(mesh, sides, &edges, &chosen);
        observer.event(Event::Advanced { done: mesh.positions.len() as u64 });
    }
    Ok(())
}

/// Edges to split, the most urgent first.
fn wanted_edges(
    mesh: &Mesh,
    sides: &Sidedness,
    edges: &Edges,
    pilot: &mut Pilot,
    unit: f32,
) -> Result<Vec<u32>, BakeError> {
    let length = |e: u32| edges.length_sq[e as usize].sqrt() / unit;
    let (long, candidates): (Vec<u32>, Vec<u32>) =
        (0..edges.ends.len() as u32).filter(|&e| length(e) > SHORTEST).partition(|&e| length(e) > LONGEST);
    pilot.learn_errors(mesh, sides, edges, &candidates)?;
    // Long edges come first, by length; then what is visibly wrong, by how much surface it is wrong on.
    let urgency = |e: u32| {
        let error = pilot.errors[&edges.key(mesh, e)];
        if error > TOLERANCE { error * length(e).powi(2) } else { 0.0 }
    };
    let long = long.into_iter().map(|e| (1e3 + length(e), e));
    let mut ranked: Vec<(f32, u32)> =
        long.chain(candidates.iter().map(|&e| (urgency(e), e))).filter(|r| r.0 > 0.0).collect();
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    Ok(ranked.into_iter().map(|r| r.1).collect())
}

#[cfg(test)]
mod tests;
