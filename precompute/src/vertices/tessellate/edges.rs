//! The edges of a mesh by position, and edges that are split together.

use crate::vertices::sidedness::weld_positions;
use lapidary_core::scene::Mesh;
use rayon::prelude::*;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

/// Undirected edges by welded position.
pub(super) struct Edges {
    /// The two welded ends of each edge, the smaller first. They stay the same when other edges are split.
    pub ends: Vec<(u32, u32)>,
    pub length_sq: Vec<f32>,
    /// For each triangle the edges opposite to its corners.
    pub of_triangle: Vec<[u32; 3]>,
    /// Number of vertices added by splitting each edge: one, or at a seam one per pair of end vertices.
    pub copies: Vec<u32>,
    /// Triangles of all edges, edge by edge.
    triangles: Vec<u32>,
    /// Where those of each edge begin, and the end of all.
    starts: Vec<u32>,
}

impl Edges {
    pub fn new(mesh: &Mesh) -> Self {
        let weld = weld_positions(mesh);
        let room = mesh.triangles.len() * 3 / 2;
        let mut ids: FxHashMap<(u32, u32), u32> = FxHashMap::with_capacity_and_hasher(room, FxBuildHasher);
        let (mut ends, mut counts) = (Vec::with_capacity(room), Vec::with_capacity(room));
        let mut of_triangle = Vec::with_capacity(mesh.triangles.len());
        for corners in &mesh.triangles {
            of_triangle.push(opposite_ends(corners.map(|v| weld[v as usize])).map(|key| {
                let id = *ids.entry(key).or_insert_with(|| {
                    ends.push(key);
                    counts.push(0);
                    ends.len() as u32 - 1
                });
                counts[id as usize] += 1;
                id
            }));
        }
        let (starts, triangles) = by_edge(&of_triangle, &counts);
        let at = |v: u32| mesh.positions[v as usize];
        let length_sq = ends.par_iter().map(|&(a, b)| at(a).distance_squared(at(b))).collect();
        let mut edges = Self { ends, length_sq, of_triangle, copies: Vec::new(), triangles, starts };
        edges.copies = (0..edges.ends.len() as u32).into_par_iter().map(|edge| edges.copies_of(mesh, edge)).collect();
        edges
    }

    /// Triangles of an edge.
    pub fn triangles(&self, edge: u32) -> &[u32] {
        &self.triangles[self.starts[edge as usize] as usize..self.starts[edge as usize + 1] as usize]
    }

    /// Number of pairs of vertices at its ends.
    fn copies_of(&self, mesh: &Mesh, edge: u32) -> u32 {
        let pair = |(t, corner): (u32, usize)| {
            let [u, v] = [1, 2].map(|next| mesh.triangles[t as usize][(corner + next) % 3]);
            (u.min(v), u.max(v))
        };
        // A triangle with two corners at one place has an edge twice.
        let corners = |&t: &u32| (0..3).filter(move |&i| self.of_triangle[t as usize][i] == edge).map(move |i| (t, i));
        let mut pairs: Vec<(u32, u32)> = self.triangles(edge).iter().flat_map(corners).map(pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.len() as u32
    }

    /// The longest edge of a triangle; ties are broken by index, consistently on both sides of an edge.
    pub fn longest(&self, triangle: u32) -> u32 {
        let edges = self.of_triangle[triangle as usize];
        let longer = |a: u32, b: u32| {
            let key = |e: u32| (self.length_sq[e as usize], e);
            if key(a) > key(b) { a } else { b }
        };
        longer(longer(edges[0], edges[1]), edges[2])
    }

    /// Edges to split: `wanted` in order of urgency, each with the edges that conformity requires, within a budget of new vertices.
    pub fn within_budget(&self, wanted: &[u32], budget: usize) -> FxHashSet<u32> {
        let mut chosen = FxHashSet::default();
        let mut left = budget;
        for &edge in wanted {
            let mut added = Vec::new();
            self.close(edge, &chosen, &mut added);
            let vertices: usize = added.iter().map(|&e| self.copies[e as usize] as usize).sum();
            if vertices > left {
                break;
            }
            left -= vertices;
            chosen.extend(added);
        }
        chosen
    }

    /// Adds `edge` and the longest edges of all triangles that splitting it touches.
    fn close(&self, edge: u32, chosen: &FxHashSet<u32>, added: &mut Vec<u32>) {
        let mut stack = vec![edge];
        while let Some(edge) = stack.pop() {
            if chosen.contains(&edge) || added.contains(&edge) {
                continue;
            }
            added.push(edge);
            stack.extend(self.triangles(edge).iter().map(|&t| self.longest(t)));
        }
    }
}

/// The ends of the edges opposite to the corners of a triangle, the smaller first.
fn opposite_ends(corners: [u32; 3]) -> [(u32, u32); 3] {
    std::array::from_fn(|i| {
        let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
        (a.min(b), a.max(b))
    })
}

/// Triangles edge by edge, after where those of each edge begin, from their numbers.
fn by_edge(of_triangle: &[[u32; 3]], counts: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0];
    starts.extend(counts.iter().scan(0, |end, count| {
        *end += count;
        Some(*end)
    }));
    let mut next = starts.clone();
    let mut triangles = vec![0; 3 * of_triangle.len()];
    for (t, edges) in (0..).zip(of_triangle) {
        for &edge in edges {
            triangles[next[edge as usize] as usize] = t;
            next[edge as usize] += 1;
        }
    }
    (starts, triangles)
}

/// The mesh vertices at the ends of an edge, in its first triangle.
pub(super) fn end_vertices(mesh: &Mesh, edges: &Edges, edge: u32) -> [u32; 2] {
    let triangle = edges.triangles(edge)[0] as usize;
    let corner = edges.of_triangle[triangle].iter().position(|&e| e == edge).unwrap_or(0);
    [mesh.triangles[triangle][(corner + 1) % 3], mesh.triangles[triangle][(corner + 2) % 3]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{floor, scene_of};
    use glam::Vec3;

    #[test]
    fn edges_know_their_triangles_and_the_vertices_that_splitting_them_adds() {
        // A strip of two triangles with vertices of their own, and one with two corners at one place.
        let mut triangles = floor(1.0, 0.0).to_vec();
        triangles.push([Vec3::X, Vec3::X, Vec3::Y]);
        let mesh = scene_of(&triangles).mesh;
        let edges = Edges::new(&mesh);
        for edge in 0..edges.ends.len() as u32 {
            let of_edge = edges.triangles(edge);
            let all = (0..3).filter(|&t| edges.of_triangle[t as usize].contains(&edge));
            assert!(
                all.clone().all(|t| of_edge.contains(&t)) && of_edge.iter().all(|t| all.clone().any(|of| of == *t))
            );
        }
        let copies = |triangles: &[u32]| {
            let edge = (0..edges.ends.len() as u32).find(|&e| edges.triangles(e) == triangles);
            edges.copies[edge.expect("there is one") as usize]
        };
        assert_eq!(copies(&[0, 1]), 2, "a seam");
        assert_eq!(copies(&[2, 2]), 2, "twice in one triangle");
        assert_eq!(copies(&[0]), 1, "a border");
    }
}
