//! Thrown pottery: a tall vase, a small bottle and a shallow bowl, closed, with foot ring, lip and inside.

use glam::{Vec2, vec2};

use crate::curve::through;
use crate::mesh::Mesh;
use crate::turned::{Profile, creased, turn};

/// A tall vase of `height` meters standing on `y = 0`: full shoulder, narrow neck, flared lip.
pub fn vase(height: f32, segments: usize) -> Mesh {
    let wall = [
        vec2(0.170, 0.006),
        vec2(0.178, 0.030),
        vec2(0.236, 0.170),
        vec2(0.296, 0.340),
        vec2(0.322, 0.510),
        vec2(0.296, 0.650),
        vec2(0.205, 0.765),
        vec2(0.112, 0.835),
        vec2(0.084, 0.890),
        vec2(0.096, 0.945),
        vec2(0.138, 0.985),
        vec2(0.146, 0.996),
        vec2(0.138, 1.000),
        vec2(0.126, 0.990),
        vec2(0.080, 0.945),
        vec2(0.064, 0.890),
        vec2(0.090, 0.830),
        vec2(0.184, 0.752),
        vec2(0.272, 0.642),
        vec2(0.298, 0.510),
        vec2(0.272, 0.340),
        vec2(0.206, 0.170),
        vec2(0.110, 0.080),
        vec2(0.0, 0.060),
    ];
    thrown(foot_ring(vec2(0.170, 0.006), 0.030), &wall, height, segments)
}

/// A slender bottle of `height` meters standing on `y = 0`.
pub fn bottle(height: f32, segments: usize) -> Mesh {
    let wall = [
        vec2(0.150, 0.006),
        vec2(0.205, 0.045),
        vec2(0.252, 0.150),
        vec2(0.236, 0.270),
        vec2(0.150, 0.380),
        vec2(0.072, 0.490),
        vec2(0.046, 0.640),
        vec2(0.044, 0.820),
        vec2(0.058, 0.950),
        vec2(0.082, 0.990),
        vec2(0.086, 0.998),
        vec2(0.078, 1.000),
        vec2(0.046, 0.950),
        vec2(0.030, 0.820),
        vec2(0.031, 0.640),
        vec2(0.054, 0.490),
        vec2(0.130, 0.380),
        vec2(0.214, 0.270),
        vec2(0.228, 0.150),
        vec2(0.180, 0.065),
        vec2(0.0, 0.045),
    ];
    thrown(foot_ring(vec2(0.150, 0.006), 0.022), &wall, height, segments)
}

/// A shallow bowl of `diameter` meters standing on `y = 0`.
pub fn bowl(diameter: f32, segments: usize) -> Mesh {
    let wall = [
        vec2(0.190, 0.006),
        vec2(0.270, 0.042),
        vec2(0.390, 0.130),
        vec2(0.466, 0.235),
        vec2(0.494, 0.330),
        vec2(0.499, 0.342),
        vec2(0.494, 0.347),
        vec2(0.484, 0.338),
        vec2(0.450, 0.242),
        vec2(0.374, 0.146),
        vec2(0.255, 0.066),
        vec2(0.120, 0.036),
        vec2(0.0, 0.030),
    ];
    thrown(foot_ring(vec2(0.190, 0.006), 0.014), &wall, diameter, segments)
}

fn thrown(foot: Profile, wall: &[Vec2], size: f32, segments: usize) -> Mesh {
    // Cells about as high as they are wide.
    let steps = if segments < 50 { 1 } else { 3 };
    let mut profile = foot;
    profile.push(through(wall, steps));
    for p in profile.iter_mut().flatten() {
        *p *= size;
    }
    turn(&profile, segments)
}

/// The underside from the axis to where the wall starts: a recessed floor and a ring to stand on.
fn foot_ring(wall_start: Vec2, recess: f32) -> Profile {
    let (outer, width) = (wall_start.x, 0.026);
    creased(&[
        vec2(0.0, recess),
        vec2(outer - 1.5 * width, recess),
        vec2(outer - width, 0.002),
        vec2(outer - 0.9 * width, 0.0),
        vec2(outer - 0.004, 0.0),
        wall_start,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn pottery_is_closed_and_stands() {
        for piece in [vase(0.5, 64), bottle(0.3, 48), bowl(0.2, 24)] {
            assert_sound(&piece);
            assert_closed(&piece);
            assert_eq!(piece.lowest(), 0.0);
        }
    }
}
