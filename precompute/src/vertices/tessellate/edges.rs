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
        let pair = |&t: &u32| {
            let [u, v] = end_vertices_in(mesh, self, edge, t);
            (u.min(v), u.max(v))
        };
        match self.triangles(edge) {
            [_] => 1,
            [one, other] => 1 + u32::from(pair(one) != pair(other)),
            many => many.iter().map(pair).collect::<FxHashSet<_>>().len() as u32,
        }
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
    let first = edges.triangles(edge)[0];
    end_vertices_in(mesh, edges, edge, first)
}

/// The same, in one of its triangles.
fn end_vertices_in(mesh: &Mesh, edges: &Edges, edge: u32, triangle: u32) -> [u32; 2] {
    let triangle = triangle as usize;
    let corner = edges.of_triangle[triangle].iter().position(|&e| e == edge).unwrap_or(0);
    [mesh.triangles[triangle][(corner + 1) % 3], mesh.triangles[triangle][(corner + 2) % 3]]
}
