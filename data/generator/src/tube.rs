//! Tubes and wires swept along a path.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use crate::mesh::Mesh;

/// One station of a swept path.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Center of the cross-section.
    pub centre: Vec3,
    /// Unit direction of the first axis of the elliptic cross-section; need not be exactly across the path.
    pub outward: Vec3,
    /// Half axes in meters: along `outward`, and sideways.
    pub radii: Vec2,
}

/// Sweeps a closed path; `u` goes along it, `v` around it.
pub fn sweep_closed(path: &[Station], sides: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let count = path.len();
    let rings: Vec<Vec<u32>> = (0..=count)
        .map(|i| {
            let along = path[(i + 1) % count].centre - path[(i + count - 1) % count].centre;
            push_ring(&mut mesh, &path[i % count], along, sides, i as f32 / count as f32)
        })
        .collect();
    stitch(&mut mesh, &rings);
    mesh.smooth_normals();
    mesh
}

/// Sweeps an open path and closes both ends with flat caps.
pub fn sweep_open(path: &[Station], sides: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let last = path.len() - 1;
    let along = |i: usize| path[(i + 1).min(last)].centre - path[i.saturating_sub(1)].centre;
    let rings: Vec<Vec<u32>> =
        (0..=last).map(|i| push_ring(&mut mesh, &path[i], along(i), sides, i as f32 / last as f32)).collect();
    stitch(&mut mesh, &rings);
    mesh.smooth_normals();
    cap(&mut mesh, &rings[0], -along(0).normalize());
    cap(&mut mesh, &rings[last], along(last).normalize());
    mesh
}

fn push_ring(mesh: &mut Mesh, at: &Station, along: Vec3, sides: usize, u: f32) -> Vec<u32> {
    let along = along.normalize();
    let outward = at.outward.reject_from_normalized(along).normalize();
    let sideways = along.cross(outward);
    (0..=sides)
        .map(|k| {
            let (sin, cos) = ((k % sides) as f32 / sides as f32 * TAU).sin_cos();
            let offset = outward * (cos * at.radii.x) + sideways * (sin * at.radii.y);
            mesh.push(at.centre + offset, Vec3::Y, Vec2::new(u, k as f32 / sides as f32))
        })
        .collect()
}

fn stitch(mesh: &mut Mesh, rings: &[Vec<u32>]) {
    for pair in rings.windows(2) {
        let (near, far) = (&pair[0], &pair[1]);
        for k in 0..near.len() - 1 {
            mesh.quad(near[k], near[k + 1], far[k + 1], far[k]);
        }
    }
}

fn cap(mesh: &mut Mesh, ring: &[u32], normal: Vec3) {
    let corners: Vec<u32> = ring[..ring.len() - 1]
        .iter()
        .map(|i| mesh.push(mesh.positions[*i as usize], normal, mesh.uvs[*i as usize]))
        .collect();
    let at = |k: usize| mesh.positions[corners[k] as usize];
    let forwards = (at(1) - at(0)).cross(at(2) - at(0)).dot(normal) > 0.0;
    for k in 1..corners.len() - 1 {
        let (b, c) = if forwards { (k, k + 1) } else { (k + 1, k) };
        mesh.triangle(corners[0], corners[b], corners[c]);
    }
}
