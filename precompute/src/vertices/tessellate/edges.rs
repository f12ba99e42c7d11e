//! The edges of a mesh by position, and edges that are split together.

use crate::vertices::sidedness::weld_positions;
use lapidary_core::scene::Mesh;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

/// Undirected edges by welded position.
pub(super) struct Edges {
    /// The two welded ends of each edge, the smaller first.
    pub ends: Vec<(u32, u32)>,
    pub length_sq: Vec<f32>,
    /// For each triangle the edges opposite to its corners.
    pub of_triangle: Vec<[u32; 3]>,
    /// Triangles of each edge.
    pub triangles: Vec<Vec<u32>>,
    /// Number of vertices added by splitting each edge: one, or at a seam one per pair of end vertices.
    pub copies: Vec<usize>,
}

impl Edges {
    pub fn new(mesh: &Mesh) -> Self {
        let weld = weld_positions(mesh);
        let room = mesh.triangles.len() * 3 / 2;
        let mut ids: FxHashMap<(u32, u32), u32> = FxHashMap::with_capacity_and_hasher(room, FxBuildHasher);
        let (mut ends, mut length_sq, mut triangles) = (Vec::new(), Vec::new(), Vec::<Vec<u32>>::new());
        let (mut copies, mut pairs) = (Vec::new(), FxHashSet::with_capacity_and_hasher(room, FxBuildHasher));
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

    pub fn key(&self, mesh: &Mesh, edge: u32) -> EdgeKey {
        let (a, b) = self.ends[edge as usize];
        let mut key = [a, b].map(|v| mesh.positions[v as usize].to_array().map(f32::to_bits));
        key.sort_unstable();
        key
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
            let vertices: usize = added.iter().map(|&e| self.copies[e as usize]).sum();
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
            stack.extend(self.triangles[edge as usize].iter().map(|&t| self.longest(t)));
        }
    }
}

/// The mesh vertices at the ends of an edge, in its first triangle.
pub(super) fn end_vertices(mesh: &Mesh, edges: &Edges, edge: u32) -> [u32; 2] {
    let triangle = edges.triangles[edge as usize][0] as usize;
    let corner = edges.of_triangle[triangle].iter().position(|&e| e == edge).unwrap_or(0);
    [mesh.triangles[triangle][(corner + 1) % 3], mesh.triangles[triangle][(corner + 2) % 3]]
}

/// The bits of both ends' positions, which, unlike edge numbers, stay the same when other edges are split.
pub(super) type EdgeKey = [[u32; 3]; 2];
