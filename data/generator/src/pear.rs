//! Pears: organic shapes for the still life.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

use crate::curve::through;
use crate::mesh::Mesh;
use crate::tube::{Station, sweep_open};
use crate::turned::turn;

/// A pear of `height` meters (without stem) standing on `y = 0`, its neck bent toward +X.
pub fn pear(height: f32) -> Mesh {
    let side = [
        vec2(0.0, 0.030),
        vec2(0.060, 0.020),
        vec2(0.130, 0.004),
        vec2(0.240, 0.030),
        vec2(0.345, 0.140),
        vec2(0.388, 0.290),
        vec2(0.360, 0.440),
        vec2(0.280, 0.580),
        vec2(0.205, 0.720),
        vec2(0.172, 0.850),
        vec2(0.135, 0.940),
        vec2(0.070, 0.985),
        vec2(0.026, 0.978),
        vec2(0.0, 0.960),
    ];
    let mut body = turn(&[through(&side, 3)], 48);
    for p in &mut body.positions {
        *p = bend(*p) * height;
    }
    body.smooth_normals();
    body.grounded()
}

/// The stem for a [`pear`] of the same height.
pub fn stem(height: f32) -> Mesh {
    let station = |k: usize| {
        let t = k as f32 / 10.0;
        let centre = bend(vec3(0.02 * (t * 2.0).sin(), 0.93 + 0.24 * t, 0.03 * t * t));
        let radius = 0.017 + 0.012 * (t - 0.35).max(0.0).powi(2) + 0.008 * (1.0 - t).powi(4);
        Station { centre: centre * height, outward: Vec3::Z, radii: Vec2::splat(radius * height) }
    };
    let path: Vec<Station> = (0..=10).map(station).collect();
    sweep_open(&path, 8)
}

/// Leans the neck and makes the belly slightly uneven, as in natural growth.
fn bend(p: Vec3) -> Vec3 {
    let lean = 0.16 * (p.y - 0.35).max(0.0).powi(2);
    let around = p.x.atan2(p.z);
    let uneven = 1.0 + 0.022 * (3.0 * around + 4.0 * p.y).sin() + 0.015 * (2.0 * around - 1.0).sin();
    vec3(p.x * uneven + lean, p.y, p.z * uneven)
}

/// Turns a pear on its side to its lowest center of gravity: the resting pose of a real one.
pub fn lying(pear: &Mesh, heading: f32) -> Affine3A {
    let tipped = |k: usize| Quat::from_rotation_z(-(0.18 + 0.14 * k as f32 / 200.0) * TAU);
    let centre = pear.positions.iter().sum::<Vec3>() / pear.positions.len() as f32;
    let best = (0..=200)
        .map(tipped)
        .min_by(|a, b| weight_height(pear, centre, *a).total_cmp(&weight_height(pear, centre, *b)));
    let rotation = best.unwrap_or_default();
    let lift = -lowest(pear, rotation);
    Affine3A::from_translation(Vec3::Y * lift) * Affine3A::from_quat(Quat::from_rotation_y(heading) * rotation)
}

fn lowest(mesh: &Mesh, rotation: Quat) -> f32 {
    mesh.positions.iter().fold(f32::INFINITY, |low, p| low.min((rotation * *p).y))
}

fn weight_height(mesh: &Mesh, centre: Vec3, rotation: Quat) -> f32 {
    (rotation * centre).y - lowest(mesh, rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn pears_are_closed() {
        for piece in [pear(0.1), stem(0.1)] {
            assert_sound(&piece);
            assert_closed(&piece);
        }
    }

    #[test]
    fn a_lying_pear_touches_the_floor() {
        let pear = pear(0.1);
        let lying = pear.clone().moved(lying(&pear, 0.7));
        assert!(lying.lowest().abs() < 1e-6);
    }
}
