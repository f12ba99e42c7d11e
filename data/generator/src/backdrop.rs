//! The studio floor that curves up into the background without a corner.

use glam::{Vec2, Vec3};

use crate::curve::{arc, line};
use crate::mesh::Mesh;

/// Half the width of the sweep, meters.
const HALF_WIDTH: f32 = 2.0;
/// Front edge of the floor.
const FRONT: f32 = 1.5;
/// Where the floor starts to rise.
const BEND: f32 = -0.62;
/// Radius of the curve.
const RADIUS: f32 = 0.6;
/// Height of the upper edge.
const TOP: f32 = 1.35;
/// Columns across.
const COLUMNS: usize = 40;

/// The sweep, `y = 0` on the floor, front faces up and towards +Z; one texture covers it once.
///
/// An open sheet seen from one side only: it stays single-sided so a bake does not light its back.
pub fn sweep() -> Mesh {
    let profile = profile();
    let total: f32 = profile.windows(2).map(|w| w[0].distance(w[1])).sum();
    let mut mesh = Mesh::default();
    let mut travelled = 0.0;
    let mut rows: Vec<Vec<u32>> = Vec::new();
    for (i, p) in profile.iter().enumerate() {
        rows.push(push_row(&mut mesh, *p, 1.0 - travelled / total));
        travelled += profile.get(i + 1).map_or(0.0, |next| p.distance(*next));
    }
    for pair in rows.windows(2) {
        for k in 0..COLUMNS {
            mesh.quad(pair[0][k], pair[0][k + 1], pair[1][k + 1], pair[1][k]);
        }
    }
    mesh.smooth_normals();
    mesh
}

fn push_row(mesh: &mut Mesh, p: Vec2, v: f32) -> Vec<u32> {
    let column = |k: usize| {
        let u = k as f32 / COLUMNS as f32;
        let x = HALF_WIDTH * (2.0 * u - 1.0);
        mesh.push(Vec3::new(x, p.y, p.x), Vec3::Y, Vec2::new(u, v))
    };
    (0..=COLUMNS).map(column).collect()
}

/// Profile from front to back: (z, y).
fn profile() -> Vec<Vec2> {
    let mut points = line(Vec2::new(FRONT, 0.0), Vec2::new(BEND, 0.0), 24);
    let mut curve = arc(Vec2::new(BEND, RADIUS), RADIUS, -std::f32::consts::FRAC_PI_2, -std::f32::consts::PI, 16);
    points.append(&mut curve.split_off(1));
    points.extend(&line(Vec2::new(BEND - RADIUS, RADIUS), Vec2::new(BEND - RADIUS, TOP), 8)[1..]);
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::assert_sound;

    #[test]
    fn the_sweep_is_sound_and_faces_the_camera() {
        let sweep = sweep();
        assert_sound(&sweep);
        assert!(sweep.normals.iter().all(|n| n.y > -1e-4 && n.z > -1e-4));
        assert!((1000..3000).contains(&sweep.positions.len()));
    }
}
