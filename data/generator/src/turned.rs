//! Surfaces of revolution, as made on a potter's wheel or a lathe.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use crate::mesh::Mesh;

/// A profile in the half plane (distance from the axis, height), made of smooth runs that meet in creases.
///
/// A closed piece runs from the axis at the bottom outwards, up, over the lip and back to the axis inside,
/// or around a ring: the surface lies to the right of the direction of travel.
pub type Profile = Vec<Vec<Vec2>>;

/// A profile with a crease at every point.
pub fn creased(points: &[Vec2]) -> Profile {
    points.windows(2).map(<[Vec2]>::to_vec).collect()
}

/// Turns `profile` around the Y axis in `segments` steps; `u` goes around once, `v` along the profile once.
pub fn turn(profile: &[Vec<Vec2>], segments: usize) -> Mesh {
    let total: f32 = profile.iter().map(|run| length(run)).sum();
    let mut mesh = Mesh::default();
    let mut travelled = 0.0;
    let mut end = None;
    for run in profile {
        let run = continued(run, end);
        turn_run(&mut mesh, &run, segments, travelled / total, total);
        travelled += length(&run);
        end = run.last().copied();
    }
    mesh
}

/// Turns one closed loop of points (counter-clockwise, axis to the left) into a smooth ring.
pub fn turn_loop(points: &[Vec2], segments: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let count = points.len();
    let total = length(points) + points[0].distance(points[count - 1]);
    let mut travelled = 0.0;
    let rings: Vec<Vec<u32>> = (0..=count)
        .map(|i| {
            let here = points[i % count];
            let along = middle_tangent(points[(i + count - 1) % count], here, points[(i + 1) % count]);
            let ring = push_ring(&mut mesh, here, along, segments, travelled / total);
            travelled += here.distance(points[(i + 1) % count]);
            ring
        })
        .collect();
    for pair in rings.windows(2) {
        stitch(&mut mesh, &pair[0], &pair[1], false, false);
    }
    mesh
}

fn turn_run(mesh: &mut Mesh, run: &[Vec2], segments: usize, v_start: f32, total: f32) {
    let last = run.len() - 1;
    let mut travelled = 0.0;
    let mut below: Option<Vec<u32>> = None;
    for i in 0..=last {
        let along = tangent(run, i);
        let ring = push_ring(mesh, run[i], along, segments, v_start + travelled / total);
        if let Some(below) = below {
            stitch(mesh, &below, &ring, run[i - 1].x == 0.0, run[i].x == 0.0);
        }
        below = Some(ring);
        travelled += if i < last { run[i].distance(run[i + 1]) } else { 0.0 };
    }
}

fn tangent(run: &[Vec2], i: usize) -> Vec2 {
    let last = run.len() - 1;
    if i == 0 {
        return end_tangent(run[0], run[1], run.get(2).copied());
    }
    if i == last {
        let before = i.checked_sub(2).map(|k| run[k]);
        return -end_tangent(run[last], run[last - 1], before);
    }
    middle_tangent(run[i - 1], run[i], run[i + 1])
}

/// Tangent at `b` of the parabola through three neighbors: exact on arcs, where the plain difference of
/// unevenly spaced points leans towards the longer side.
fn middle_tangent(a: Vec2, b: Vec2, c: Vec2) -> Vec2 {
    let (ab, bc) = (b - a, c - b);
    ab / ab.length_squared() + bc / bc.length_squared()
}

/// Tangent at the end `a` of a curve that continues through `b` and `c`: the parabola's.
fn end_tangent(a: Vec2, b: Vec2, c: Option<Vec2>) -> Vec2 {
    let Some(c) = c else { return b - a };
    let (ab, bc) = (b - a, c - b);
    let (h, k) = (ab.length(), bc.length());
    let (first, second) = (ab / h, bc / k);
    first + (first - second) * (h / (h + k))
}

fn push_ring(mesh: &mut Mesh, at: Vec2, along: Vec2, segments: usize, v: f32) -> Vec<u32> {
    let normal = Vec2::new(along.y, -along.x).normalize();
    (0..=segments)
        .map(|j| {
            // The last column equals the first, bit for bit, which closes the seam.
            let angle = (j % segments) as f32 / segments as f32 * TAU;
            let around = Vec3::new(angle.sin(), 0.0, angle.cos());
            // On the axis a column represents the triangle on its right: shift the texture by half a step.
            let (normal, shift) = if at.x == 0.0 {
                (Vec3::Y * normal.y.signum(), 0.5)
            } else {
                (around * normal.x + Vec3::Y * normal.y, 0.0)
            };
            let u = (j as f32 + shift) / segments as f32;
            mesh.push(around * at.x + Vec3::Y * at.y, normal, Vec2::new(u, 1.0 - v))
        })
        .collect()
}

fn stitch(mesh: &mut Mesh, below: &[u32], above: &[u32], axis_below: bool, axis_above: bool) {
    for j in 0..below.len() - 1 {
        match (axis_below, axis_above) {
            (true, _) => mesh.triangle(below[j], above[j + 1], above[j]),
            (_, true) => mesh.triangle(below[j], below[j + 1], above[j]),
            _ => mesh.quad(below[j], below[j + 1], above[j + 1], above[j]),
        }
    }
}

/// A run that starts, bit for bit, where the last one ended, with points near the axis snapped to it: arcs miss both by rounding.
fn continued(run: &[Vec2], end: Option<Vec2>) -> Vec<Vec2> {
    let on_axis = |p: &Vec2| if p.x.abs() < 1e-6 { Vec2::new(0.0, p.y) } else { *p };
    let mut run: Vec<Vec2> = run.iter().map(on_axis).collect();
    if let Some(end) = end {
        debug_assert!(run[0].distance(end) < 1e-4, "the profile is torn at {end}");
        run[0] = end;
    }
    run
}

fn length(run: &[Vec2]) -> f32 {
    run.windows(2).map(|w| w[0].distance(w[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::arc;
    use crate::mesh::checks::{assert_closed, assert_sound, volume};
    use std::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn a_turned_half_circle_is_a_sphere() {
        let sphere = turn(&[arc(Vec2::ZERO, 1.0, -FRAC_PI_2, FRAC_PI_2, 64)], 128);
        assert_sound(&sphere);
        assert_closed(&sphere);
        assert!((volume(&sphere) - 4.0 / 3.0 * PI).abs() < 0.01);
        for (p, n) in sphere.positions.iter().zip(&sphere.normals) {
            assert!(p.normalize().dot(*n) > 0.9999, "{p} {n}");
        }
    }

    #[test]
    fn a_turned_loop_is_a_torus() {
        let mut circle = arc(Vec2::new(1.0, 0.0), 0.25, 0.0, TAU, 32);
        circle.pop();
        let torus = turn_loop(&circle, 96);
        assert_sound(&torus);
        assert_closed(&torus);
        let exact = 2.0 * PI * PI * 0.25 * 0.25;
        assert!((volume(&torus) - exact).abs() < 0.02 * exact);
    }
}
