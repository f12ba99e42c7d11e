//! Tessellation where visibility varies, by conforming longest-edge bisection (Rivara 1984).
//!
//! Cuts are interpolated linearly inside triangles, so vertices are needed where visibility changes: without them a
//! floor of two triangles has no shadow. An edge is split if it is long for the vertex budget, or if the pilot visibility
//! at its midpoint differs from the mean of its ends; a triangle with an edge to split also splits its longest edge, which
//! keeps angles bounded. Edges are told apart by position, so that seams of normals and texture coordinates do not crack.

use crate::{
    BakeError,
    bake::cancelled,
    bake_points::{BakePoint, BakePoints},
    observer::{Event, Observer},
    sidedness::{Sidedness, weld_positions},
};
use glam::Vec3;
use lapidary_core::{
    ray::{DirectionSet, Intersector},
    scene::Mesh,
    sphere::fibonacci_directions,
};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// Directions of the pilot visibility; the error of an edge is known to about 1 / √256.
const DIRECTIONS: usize = 256;
/// Part of the sphere that must be wrong at an edge's midpoint for the edge to be split.
const TOLERANCE: f32 = 0.01;
/// Longest edge that is never left whole, and shortest that is never split, in units of the edge length at which equal
/// triangles over the whole surface would use up the budget.
const LONGEST: f32 = 6.0;
const SHORTEST: f32 = 0.25;
/// Rounds of splitting; each at most halves all edges.
const ROUNDS: usize = 12;

/// Splits edges of `mesh` until it has at most `budget` vertices or visibility is linear enough. `sides` keeps one entry
/// a triangle.
///
/// # Errors
/// [`BakeError::Cancelled`], within the tracing of a point after the observer asked for it.
pub fn tessellate(
    mesh: &mut Mesh,
    sides: &mut Sidedness,
    scene: &Intersector,
    budget: usize,
    observer: &dyn Observer,
) -> Result<(), BakeError> {
    let area: f32 = (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).sum();
    let unit = (1.15 * area / budget.max(1) as f32).sqrt();
    let directions = DirectionSet::new(&fibonacci_directions(DIRECTIONS));
    let mut pilot = Pilot { scene, directions, errors: HashMap::new(), observer };
    for _ in 0..ROUNDS {
        cancelled(observer)?;
        if mesh.positions.len() >= budget {
            break;
        }
        let edges = Edges::new(mesh);
        let wanted = wanted_edges(mesh, sides, &edges, &mut pilot, unit)?;
        if wanted.is_empty() {
            break;
        }
        let chosen = edges.within_budget(&wanted, budget - mesh.positions.len());
        cancelled(observer)?;
        if chosen.is_empty() {
            break;
        }
        split_edges(mesh, sides, &edges, &chosen);
        observer.event(Event::Advanced { done: mesh.positions.len() as u64 });
    }
    Ok(())
}

/// Undirected edges by welded position.
struct Edges {
    /// The two welded ends of each edge, the smaller first.
    ends: Vec<(u32, u32)>,
    length_sq: Vec<f32>,
    /// For each triangle the edges opposite to its corners.
    of_triangle: Vec<[u32; 3]>,
    /// Triangles of each edge.
    triangles: Vec<Vec<u32>>,
    /// Vertices that splitting each edge makes: one, or at a seam one for each pair of vertices at its ends.
    copies: Vec<usize>,
}

impl Edges {
    fn new(mesh: &Mesh) -> Self {
        let weld = weld_positions(mesh);
        let mut ids: HashMap<(u32, u32), u32> = HashMap::with_capacity(mesh.triangles.len() * 3 / 2);
        let (mut ends, mut length_sq, mut triangles) = (Vec::new(), Vec::new(), Vec::<Vec<u32>>::new());
        let (mut copies, mut pairs) = (Vec::new(), HashSet::new());
        let mut of_triangle = Vec::with_capacity(mesh.triangles.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            of_triangle.push(std::array::from_fn(|i| {
                let (a, b) = (weld[corners[(i + 1) % 3] as usize], weld[corners[(i + 2) % 3] as usize]);
                let key = (a.min(b), a.max(b));
                let id = *ids.entry(key).or_insert_with(|| {
                    ends.push(key);
                    length_sq.push(mesh.positions[a as usize].distance_squared(mesh.positions[b as usize]));
                    triangles.push(Vec::new());
                    copies.push(0);
                    ends.len() as u32 - 1
                });
                triangles[id as usize].push(t as u32);
                let (u, v) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                copies[id as usize] += usize::from(pairs.insert((u.min(v), u.max(v))));
                id
            }));
        }
        Self { ends, length_sq, of_triangle, triangles, copies }
    }

    fn key(&self, mesh: &Mesh, edge: u32) -> EdgeKey {
        let (a, b) = self.ends[edge as usize];
        let mut key = [a, b].map(|v| mesh.positions[v as usize].to_array().map(f32::to_bits));
        key.sort_unstable();
        key
    }

    /// The longest edge of a triangle; ties go by index, alike on both sides of an edge.
    fn longest(&self, triangle: u32) -> u32 {
        let edges = self.of_triangle[triangle as usize];
        let longer = |a: u32, b: u32| {
            let key = |e: u32| (self.length_sq[e as usize], e);
            if key(a) > key(b) { a } else { b }
        };
        longer(longer(edges[0], edges[1]), edges[2])
    }

    /// Edges to split: `wanted` in order of urgency and what conformity adds to each, while new vertices are left.
    fn within_budget(&self, wanted: &[u32], budget: usize) -> HashSet<u32> {
        let mut chosen = HashSet::new();
        let mut left = budget;
        for &edge in wanted {
            let mut added = Vec::new();
            self.close(edge, &chosen, &mut added);
            let vertices: usize = added.iter().map(|&e| self.copies[e as usize]).sum();
            if vertices > left {
                break;
            }
            left -= vertices;
            chosen.extend(added);
        }
        chosen
    }

    /// `edge`, and the longest edges of all triangles that splitting it touches.
    fn close(&self, edge: u32, chosen: &HashSet<u32>, added: &mut Vec<u32>) {
        let mut stack = vec![edge];
        while let Some(edge) = stack.pop() {
            if chosen.contains(&edge) || added.contains(&edge) {
                continue;
            }
            added.push(edge);
            stack.extend(self.triangles[edge as usize].iter().map(|&t| self.longest(t)));
        }
    }
}

/// Visibility from single points over few directions.
struct Pilot<'a> {
    scene: &'a Intersector,
    directions: DirectionSet,
    /// Errors at the midpoints of edges, kept from round to round: most edges stay whole.
    errors: HashMap<EdgeKey, f32>,
    /// Asked before each point whether to go on: a round traces millions of rays.
    observer: &'a dyn Observer,
}

/// The bits of both ends' positions, which, unlike numbers, stay the same when others are split.
type EdgeKey = [[u32; 3]; 2];

type Seen = [u8; DIRECTIONS];

impl Pilot<'_> {
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
    fn learn_errors(
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

/// The mesh vertices at the ends of an edge, in its first triangle.
fn end_vertices(mesh: &Mesh, edges: &Edges, edge: u32) -> [u32; 2] {
    let triangle = edges.triangles[edge as usize][0] as usize;
    let corner = edges.of_triangle[triangle].iter().position(|&e| e == edge).unwrap_or(0);
    [mesh.triangles[triangle][(corner + 1) % 3], mesh.triangles[triangle][(corner + 2) % 3]]
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

/// Splits the chosen edges at their midpoints. For every triangle with a chosen edge, its longest is chosen too.
fn split_edges(mesh: &mut Mesh, sides: &mut Sidedness, edges: &Edges, chosen: &HashSet<u32>) {
    let mut midpoints = HashMap::new();
    for t in 0..edges.of_triangle.len() {
        if !edges.of_triangle[t].iter().any(|e| chosen.contains(e)) {
            continue;
        }
        let longest = edges.longest(t as u32);
        let apex = edges.of_triangle[t].iter().position(|&e| e == longest).unwrap_or(0);
        let corner = |i: usize| mesh.triangles[t][(apex + i) % 3];
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let middle = midpoint_vertex(mesh, &mut midpoints, b, c);
        // The halves, each with the edge that it shares with the whole triangle.
        let half = |mesh: &mut Mesh, midpoints: &mut _, edge: u32, [p, q, m]: [u32; 3]| {
            if !chosen.contains(&edge) {
                return vec![[p, q, m]];
            }
            let n = midpoint_vertex(mesh, midpoints, p, q);
            vec![[p, n, m], [n, q, m]]
        };
        let edge_opposite = |i: usize| edges.of_triangle[t][(apex + i) % 3];
        let mut parts = half(mesh, &mut midpoints, edge_opposite(2), [a, b, middle]);
        parts.extend(half(mesh, &mut midpoints, edge_opposite(1), [c, a, middle]));
        replace_triangle(mesh, sides, t, &parts);
    }
}

/// Puts the first part in the triangle's place and the others at the end.
fn replace_triangle(mesh: &mut Mesh, sides: &mut Sidedness, t: usize, parts: &[[u32; 3]]) {
    mesh.triangles[t] = parts[0];
    for &part in &parts[1..] {
        mesh.triangles.push(part);
        mesh.triangle_material.push(mesh.triangle_material[t]);
        mesh.triangle_object.push(mesh.triangle_object[t]);
        sides.two_sided.push(sides.two_sided[t]);
        sides.closed.push(sides.closed[t]);
    }
}

/// The vertex between two vertices, made at the first call for them.
fn midpoint_vertex(mesh: &mut Mesh, midpoints: &mut HashMap<(u32, u32), u32>, a: u32, b: u32) -> u32 {
    let key = (a.min(b), a.max(b));
    if let Some(&known) = midpoints.get(&key) {
        return known;
    }
    // In the order of the key, so that both triangles of a seam compute the same bits.
    let (a, b) = (key.0 as usize, key.1 as usize);
    let (pa, pb) = (mesh.positions[a], mesh.positions[b]);
    mesh.positions.push(0.5 * (pa + pb));
    mesh.normals.push((mesh.normals[a] + mesh.normals[b]).try_normalize().unwrap_or(mesh.normals[a]));
    let (ta, tb) = (mesh.tangents[a], mesh.tangents[b]);
    let tangent: Vec3 = (ta.truncate() + tb.truncate()).try_normalize().unwrap_or(ta.truncate());
    mesh.tangents.push(tangent.extend(ta.w));
    mesh.uvs.push(0.5 * (mesh.uvs[a] + mesh.uvs[b]));
    let id = mesh.positions.len() as u32 - 1;
    midpoints.insert(key, id);
    id
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        observer::Silent,
        sidedness::{
            classify,
            tests::{cuboid, floor, scene_of},
        },
    };
    use lapidary_core::scene::Scene;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn box_over_floor() -> Scene {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
        scene_of(&triangles)
    }

    fn tessellated(budget: usize) -> Scene {
        let mut scene = box_over_floor();
        let mut sides = classify(&scene);
        let intersector = Intersector::new(&scene.mesh);
        tessellate(&mut scene.mesh, &mut sides, &intersector, budget, &Silent).unwrap();
        assert_eq!(sides.two_sided.len(), scene.mesh.triangles.len());
        scene
    }

    fn area(mesh: &Mesh) -> f32 {
        (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).sum()
    }

    /// No vertex lies inside an edge of a triangle that does not have it as a corner.
    fn is_conforming(mesh: &Mesh) -> bool {
        let edges = Edges::new(mesh);
        let positions: HashSet<[u32; 3]> = mesh.positions.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
        edges.ends.iter().all(|&(a, b)| {
            let middle = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
            !positions.contains(&middle.to_array().map(f32::to_bits))
        })
    }

    #[test]
    fn the_result_is_valid_conforming_and_has_the_same_surface() {
        let (before, after) = (box_over_floor(), tessellated(3000));
        assert_eq!(after.mesh.validate(1, 1), Ok(()));
        assert!(after.mesh.positions.len() > 1000 && after.mesh.positions.len() <= 3000);
        assert!((area(&after.mesh) / area(&before.mesh) - 1.0).abs() < 1e-4);
        assert!(is_conforming(&after.mesh));
        let mut cracked = after.mesh.clone();
        let edges = Edges::new(&cracked);
        let [a, b] = end_vertices(&cracked, &edges, 0);
        midpoint_vertex(&mut cracked, &mut HashMap::new(), a, b);
        assert!(!is_conforming(&cracked), "negative control: a hanging vertex is noticed");
    }

    #[test]
    fn vertices_gather_where_the_shadow_changes() {
        let mesh = tessellated(3000).mesh;
        let on_floor = |near: f32, far: f32| {
            let ring = |p: &&Vec3| {
                let r = Vec3::new(p.x - 0.3, 0.0, p.z - 0.2).length();
                p.y == 0.0 && r >= near && r < far
            };
            let area = std::f32::consts::PI * (far * far - near * near);
            mesh.positions.iter().filter(ring).count() as f32 / area
        };
        assert!(on_floor(0.0, 0.8) > 3.0 * on_floor(1.2, 1.7), "{} and {}", on_floor(0.0, 0.8), on_floor(1.2, 1.7));
    }

    #[test]
    fn no_budget_leaves_the_mesh_alone() {
        assert_eq!(tessellated(3).mesh, box_over_floor().mesh);
    }
    /// Asks to stop when it has been asked `limit` times.
    struct Impatient {
        asked: AtomicUsize,
        limit: usize,
    }

    impl Observer for Impatient {
        fn event(&self, _event: Event) {}

        fn cancelled(&self) -> bool {
            self.asked.fetch_add(1, Ordering::Relaxed) >= self.limit
        }
    }

    /// Whether tessellation was cancelled, how often it asked, and the vertices that there were then.
    fn asked_until(limit: usize) -> (bool, usize, usize) {
        let mut scene = box_over_floor();
        let mut sides = classify(&scene);
        let intersector = Intersector::new(&scene.mesh);
        let observer = Impatient { asked: AtomicUsize::new(0), limit };
        let result = tessellate(&mut scene.mesh, &mut sides, &intersector, 3000, &observer);
        (result.is_err(), observer.asked.into_inner(), scene.mesh.positions.len())
    }

    #[test]
    fn cancelling_stops_within_a_round() {
        let (cancelled, all, vertices) = asked_until(usize::MAX);
        assert!(!cancelled && all > 10 * ROUNDS, "points are asked about, not rounds: {all}");
        let (cancelled, asked, fewer) = asked_until(all / 2);
        assert!(cancelled && fewer < vertices, "{fewer} of {vertices} vertices");
        assert!(asked < all * 3 / 4, "asked {asked} times, half of all is {}", all / 2);
    }
}
