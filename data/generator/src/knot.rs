//! A trefoil knot: the (2, 3) torus knot as a polished tube, standing on two of its lobes.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec3};

use crate::mesh::Mesh;
use crate::tube::{Station, sweep_closed};

/// A knot whose center line runs on a torus of radius `major` and `minor` meters, as a tube of radius `tube`. `stations` along the
/// knot; a multiple of three keeps the lobes alike. It stands upright on `y = 0`, seen along its axis from +Z.
pub fn trefoil(major: f32, minor: f32, tube: f32, stations: usize) -> Mesh {
    let path: Vec<Station> = (0..stations).map(|k| station(k as f32 / stations as f32, major, minor, tube)).collect();
    let mesh = sweep_closed(&path, stations / 12);
    // One lobe points up, so that the other two stand.
    mesh.grounded()
}

fn station(t: f32, major: f32, minor: f32, tube: f32) -> Station {
    let (around, over) = (2.0 * TAU * t, 3.0 * TAU * t);
    let radial = vec3(around.sin(), around.cos(), 0.0);
    // The torus' own normal gives a closed frame, where parallel transport would need a twist.
    let outward = radial * over.cos() + Vec3::Z * over.sin();
    Station { centre: radial * major + outward * minor, outward, radii: Vec2::splat(tube) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn the_knot_is_closed() {
        let knot = trefoil(0.09, 0.04, 0.02, 240);
        assert_sound(&knot);
        assert_closed(&knot);
    }
}
