//! A round brilliant cut: 57 facets and a faceted girdle, every facet flat.

use std::f32::consts::PI;

use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::mesh::Mesh;

/// Crown angle of the usual "ideal" proportions (Tolkowsky 1919), degrees.
const CROWN_ANGLE: f32 = 34.5;
/// Pavilion angle, degrees.
const PAVILION_ANGLE: f32 = 40.75;
/// Radius of the table's corners, in girdle radii.
const TABLE: f32 = 0.57;
/// Radius of the star facets' tips.
const STAR: f32 = 0.79;
/// Radius of the lower halves' tips.
const LOWER_HALF: f32 = 0.24;
/// Half the girdle's thickness.
const GIRDLE: f32 = 0.018;

/// The gem of the given girdle diameter in meters: the table faces up, the girdle lies at `y = 0`.
pub fn brilliant(diameter: f32) -> Mesh {
    let mut mesh = Mesh::default();
    let scale = 0.5 * diameter;
    for facet in facets() {
        let corners: Vec<Vec3> = facet.iter().map(|p| *p * scale).collect();
        push_facet(&mut mesh, &corners);
    }
    mesh
}

/// The gem lying on a table: on one pavilion main facet, its lowest point at `y = 0`, its table facet turned toward +Z.
pub fn resting(diameter: f32) -> Mesh {
    // The pavilion main around +Z has the normal (0, -cos a, sin a): turn it to point down.
    let lying = Quat::from_rotation_x(PAVILION_ANGLE.to_radians());
    brilliant(diameter).moved(Affine3A::from_quat(lying)).grounded()
}

/// Point `step` sixteenths of a turn from +Z, at `radius` and `height`.
fn point(step: usize, radius: f32, height: f32) -> Vec3 {
    let angle = (step % 16) as f32 * PI / 8.0;
    Vec3::new(radius * angle.sin(), height, radius * angle.cos())
}

/// Height above the girdle of a main facet's plane. Tips between two mains (`between`) lie on both planes,
/// which keeps the four-cornered mains flat.
fn rise(radius: f32, between: bool, angle: f32) -> f32 {
    let along = if between { radius * (PI / 8.0).cos() } else { radius };
    (1.0 - along) * angle.to_radians().tan()
}

/// All facets, counter-clockwise from outside, girdle radius 1.
fn facets() -> Vec<Vec<Vec3>> {
    let table = |k: usize| point(2 * k, TABLE, GIRDLE + rise(TABLE, false, CROWN_ANGLE));
    let star = |k: usize| point(2 * k + 1, STAR, GIRDLE + rise(STAR, true, CROWN_ANGLE));
    let lower = |k: usize| point(2 * k + 1, LOWER_HALF, -GIRDLE - rise(LOWER_HALF, true, PAVILION_ANGLE));
    let top = |step: usize| point(step, 1.0, GIRDLE);
    let bottom = |step: usize| point(step, 1.0, -GIRDLE);
    let culet = Vec3::Y * (-GIRDLE - rise(0.0, false, PAVILION_ANGLE));

    let mut facets = vec![(0..8).map(table).collect()];
    for k in 0..8 {
        let (before, next) = ((k + 7) % 8, k + 1);
        facets.push(vec![table(k), star(before), top(2 * k), star(k)]);
        facets.push(vec![table(k), star(k), table(next)]);
        facets.push(vec![top(2 * k), top(2 * k + 1), star(k)]);
        facets.push(vec![top(2 * k + 1), top(2 * k + 2), star(k)]);
        facets.push(vec![culet, lower(k), bottom(2 * k), lower(before)]);
        facets.push(vec![bottom(2 * k), lower(k), bottom(2 * k + 1)]);
        facets.push(vec![bottom(2 * k + 1), lower(k), bottom(2 * k + 2)]);
    }
    for step in 0..16 {
        facets.push(vec![bottom(step), bottom(step + 1), top(step + 1), top(step)]);
    }
    facets
}

fn push_facet(mesh: &mut Mesh, corners: &[Vec3]) {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let (right, up) = normal.any_orthonormal_pair();
    let indices: Vec<u32> =
        corners.iter().map(|p| mesh.push(*p, normal, Vec2::new(p.dot(right), p.dot(up)) * 10.0)).collect();
    for k in 1..indices.len() - 1 {
        mesh.triangle(indices[0], indices[k], indices[k + 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn the_gem_is_closed() {
        let gem = brilliant(0.1);
        assert_sound(&gem);
        assert_closed(&gem);
    }

    #[test]
    fn facets_are_flat() {
        for facet in facets() {
            let normal = (facet[1] - facet[0]).cross(facet[2] - facet[0]).normalize();
            assert!(facet.iter().all(|p| (*p - facet[0]).dot(normal).abs() < 1e-5), "{facet:?}");
        }
    }

    #[test]
    fn the_resting_gem_lies_on_a_whole_facet() {
        let gem = resting(0.1);
        let touching = gem.positions.iter().filter(|p| p.y < 1e-5).count();
        assert!(touching >= 4, "{touching} corners touch");
    }
}
