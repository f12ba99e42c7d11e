//! Splitting edges at their midpoints.

use super::edges::Edges;
use crate::vertices::sidedness::Sidedness;
use glam::Vec3;
use lapidary_core::scene::Mesh;
use rustc_hash::{FxHashMap, FxHashSet};

/// Splits the chosen edges at their midpoints. For every triangle with a chosen edge, its longest edge must also be chosen.
pub(super) fn split_edges(mesh: &mut Mesh, sides: &mut Sidedness, edges: &Edges, chosen: &FxHashSet<u32>) {
    let mut midpoints = FxHashMap::default();
    for t in 0..edges.of_triangle.len() {
        if !edges.of_triangle[t].iter().any(|e| chosen.contains(e)) {
            continue;
        }
        let longest = edges.longest(t as u32);
        let apex = edges.of_triangle[t].iter().position(|&e| e == longest).unwrap_or(0);
        let corner = |i: usize| mesh.triangles[t][(apex + i) % 3];
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let middle = midpoint_vertex(mesh, &mut midpoints, b, c);
        // The halves, each with the edge it shares with the whole triangle.
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

/// Replaces the triangle by the first part and appends the others.
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

/// The vertex between two vertices, created at the first call for them.
pub(super) fn midpoint_vertex(mesh: &mut Mesh, midpoints: &mut FxHashMap<(u32, u32), u32>, a: u32, b: u32) -> u32 {
    let key = (a.min(b), a.max(b));
    if let Some(&known) = midpoints.get(&key) {
        return known;
    }
    // In key order, so that both triangles at a seam compute the same bits.
    let (a, b) = (key.0 as usize, key.1 as usize);
    let (pa, pb) = (mesh.positions[a], mesh.positions[b]);
    mesh.positions.push(0.5 * (pa + pb));
    mesh.normals.push((mesh.normals[a] + mesh.normals[b]).try_normalize().unwrap_or(mesh.normals[a]));
    let (ta, tb) = (mesh.tangents[a], mesh.tangents[b]);
    let tangent: Vec3 = (ta.truncate() + tb.truncate()).try_normalize().unwrap_or(ta.truncate());
    mesh.tangents.push(tangent.extend(ta.w));
    mesh.uvs.push(0.5 * (mesh.uvs[a] + mesh.uvs[b]));
    if !mesh.second_uvs.is_empty() {
        mesh.second_uvs.push(0.5 * (mesh.second_uvs[a] + mesh.second_uvs[b]));
    }
    if !mesh.colors.is_empty() {
        mesh.colors.push(0.5 * (mesh.colors[a] + mesh.colors[b]));
    }
    let id = mesh.positions.len() as u32 - 1;
    midpoints.insert(key, id);
    id
}
