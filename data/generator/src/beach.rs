//! A stony beach with any number of vertices, for scaling measurements. It is not part of the bundle.
//!
//! Half of the vertices are in the sand, half in the stones, so visibility varies everywhere.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

use crate::mesh::Mesh;
use crate::noise::{fractal, unit};
use crate::scene::{Camera, Material, Scene};

/// Side of the square of sand in meters.
const SIDE: f32 = 20.0;
/// Height of the dunes in meters.
const DUNES: f32 = 0.5;
/// Number of different stones, and of copies of each.
const STONES: usize = 16;
const TIMES: usize = 15;
const SEED: u32 = 71;

/// Composes the scene of about `vertices` vertices and twice as many triangles.
pub fn beach(vertices: usize) -> Scene {
    let half = 0.5 * vertices as f32;
    let mut scene = Scene { name: "beach", materials: materials(), ..Scene::default() };
    scene.add("Sand", sand(half.sqrt().max(2.0) as usize), "Sand", Affine3A::IDENTITY);
    // A stone has twice as many segments as rings.
    let rings = (half / (2 * STONES * TIMES) as f32).sqrt().max(3.0) as usize;
    for shape in 0..STONES {
        let radius = 0.1 + 0.3 * random(shape, 0);
        let piece = scene.piece(&format!("Stone {shape}"), stone(shape as u32, radius, rings), "Basalt");
        for time in 0..TIMES {
            scene.place(&format!("Stone {shape}.{time}"), piece, lying(shape * TIMES + time, radius));
        }
    }
    scene.cameras =
        vec![Camera { name: "main", eye: vec3(0.0, 2.2, 9.0), target: vec3(0.0, 0.0, 1.0), vertical_fov: 40.0 }];
    scene
}

fn materials() -> Vec<Material> {
    vec![
        Material::dielectric("Sand", [0.55, 0.44, 0.30], 0.9),
        Material::dielectric("Basalt", [0.09, 0.09, 0.10], 0.45),
    ]
}

fn random(i: usize, what: u32) -> f32 {
    unit(i as i32, 0, SEED + what)
}

/// Height of the sand in meters over a place of the unit square.
fn height(uv: Vec2) -> f32 {
    let ripples = 0.02 * fractal(uv, (40, 90), 2, SEED + 1);
    DUNES * fractal(uv, (4, 3), 3, SEED) + ripples
}

fn sand(side: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let place = |i: usize| i as f32 / (side - 1) as f32;
    for (z, x) in (0..side).flat_map(|z| (0..side).map(move |x| (z, x))) {
        let uv = vec2(place(x), place(z));
        mesh.push(vec3(SIDE * (uv.x - 0.5), height(uv), SIDE * (uv.y - 0.5)), Vec3::Y, uv);
    }
    add_cells(&mut mesh, side, side);
    mesh.smooth_normals();
    mesh
}

/// A pebble: a flattened ball with dents.
fn stone(shape: u32, radius: f32, rings: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let segments = 2 * rings;
    for (ring, segment) in (0..=rings).flat_map(|r| (0..=segments).map(move |s| (r, s))) {
        let uv = vec2(segment as f32 / segments as f32, ring as f32 / rings as f32);
        // Where a seam or a pole closes, both sides must be the same point.
        let (polar, around) = (PI * uv.y, if segment == segments { 0.0 } else { TAU * uv.x });
        let sine = if ring == 0 || ring == rings { 0.0 } else { polar.sin() };
        let direction = vec3(sine * around.sin(), polar.cos(), sine * around.cos());
        let dents = sine * fractal(vec2(around / TAU, uv.y), (6, 5), 3, SEED + 8 * (shape + 1));
        mesh.push(radius * (1.0 + 0.12 * dents) * direction * vec3(1.0, 0.7, 0.85), direction, uv);
    }
    add_cells(&mut mesh, segments + 1, rings + 1);
    mesh.smooth_normals();
    mesh
}

/// Two triangles for each cell of a lattice of rows, one beside a pole.
fn add_cells(mesh: &mut Mesh, columns: usize, rows: usize) {
    for (row, column) in (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| (r, c))) {
        let at = |r: usize, c: usize| ((row + r) * columns + column + c) as u32;
        for [a, b, c] in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
            let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
            if p != q && q != r && r != p {
                mesh.triangle(a, b, c);
            }
        }
    }
}

/// Placement of a stone, a fifth of it in the sand.
fn lying(i: usize, radius: f32) -> Affine3A {
    let uv = vec2(0.05 + 0.9 * random(i, 2), 0.05 + 0.9 * random(i, 3));
    let tilt = Quat::from_rotation_y(TAU * random(i, 4)) * Quat::from_rotation_x(0.5 * random(i, 5));
    let place = vec3(SIDE * (uv.x - 0.5), height(uv) + 0.4 * radius, SIDE * (uv.y - 0.5));
    Affine3A::from_rotation_translation(tilt, place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_about_as_many_vertices_as_asked_for_and_twice_as_many_triangles() {
        for vertices in [200_000, 600_000] {
            let scene = beach(vertices);
            let ratio = scene.vertex_count() as f32 / vertices as f32;
            assert!((0.8..1.2).contains(&ratio), "{ratio}");
            let triangles = scene.triangle_count() as f32 / scene.vertex_count() as f32;
            assert!((1.7..2.0).contains(&triangles), "{triangles}");
        }
    }

    #[test]
    fn stones_are_closed_and_sand_looks_up() {
        let stone = stone(3, 0.2, 12);
        crate::mesh::checks::assert_closed(&stone);
        assert!(sand(20).normals.iter().all(|n| n.y > 0.5));
        let outward = stone.positions.iter().zip(&stone.normals).filter(|(p, n)| p.dot(**n) > 0.0).count();
        assert!(outward > stone.positions.len() * 9 / 10);
    }
}
