//! A shader ball: a thick shell with a groove and a round opening, a core inside, and a supporting ring.
//!
//! Shell, core and ring are separate pieces so that each can have its own material.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3, vec2};

use crate::curve::{arc, line};
use crate::mesh::Mesh;
use crate::turned::{turn, turn_loop};

/// Angle of the opening's rim from its axis.
const OPENING: f32 = 0.72;
/// Inner radius of the shell, in outer radii.
const INNER: f32 = 0.90;
/// Radius of the core.
const CORE: f32 = 0.66;
/// Height of the ball's center above the floor.
const CENTRE: f32 = 1.072;
/// Angle by which the opening's axis leans back from +Z toward +Y.
const LEAN: f32 = 0.55;

/// The pieces of a ball of the given outer radius in meters; the ring stands on `y = 0`, the opening faces +Z and up.
pub struct ShaderBall {
    /// Outer shell with opening and groove.
    pub shell: Mesh,
    /// Sphere inside, on a stem to the back of the shell.
    pub core: Mesh,
    /// Ring that supports the shell.
    pub ring: Mesh,
}

/// Builds the ball.
pub fn shader_ball(radius: f32) -> ShaderBall {
    let tilt = Affine3A::from_rotation_translation(Quat::from_rotation_x(FRAC_PI_2 - LEAN), Vec3::Y * CENTRE * radius);
    ShaderBall {
        shell: turn(&scaled(shell_profile(), radius), 76).moved(tilt),
        core: turn(&scaled(core_profile(), radius), 48).moved(tilt),
        ring: turn_loop(&scaled(vec![ring_profile()], radius)[0], 72),
    }
}

fn scaled(mut profile: Vec<Vec<Vec2>>, radius: f32) -> Vec<Vec<Vec2>> {
    for p in profile.iter_mut().flatten() {
        *p *= radius;
    }
    profile
}

/// Point on the sphere of `radius` at `angle` from the opening's axis.
fn polar(radius: f32, angle: f32) -> Vec2 {
    vec2(radius * angle.sin(), radius * angle.cos())
}

/// From the back pole over the outside and its groove to the rim, and back along the inside.
fn shell_profile() -> Vec<Vec<Vec2>> {
    let sphere = |from: f32, to: f32, steps| arc(Vec2::ZERO, 1.0, FRAC_PI_2 - from, FRAC_PI_2 - to, steps);
    let pole = FRAC_PI_2 * 2.0;
    let (groove, half_width, depth) = (1.78, 0.035, 0.955);
    let middle = 0.5 * (1.0 + INNER);
    let half_wall = 0.5 * (1.0 - INNER);
    let rim = polar(middle, OPENING);
    let outwards = FRAC_PI_2 - OPENING;
    vec![
        sphere(pole, groove + half_width, 16),
        line(polar(1.0, groove + half_width), polar(depth, groove + half_width), 2),
        arc(Vec2::ZERO, depth, FRAC_PI_2 - groove - half_width, FRAC_PI_2 - groove + half_width, 3),
        line(polar(depth, groove - half_width), polar(1.0, groove - half_width), 2),
        sphere(groove - half_width, OPENING, 18),
        arc(rim, half_wall, outwards, outwards + TAU / 2.0, 8),
        arc(Vec2::ZERO, INNER, FRAC_PI_2 - OPENING, -FRAC_PI_2, 28),
    ]
}

/// A sphere with a stem to the back.
fn core_profile() -> Vec<Vec<Vec2>> {
    let stem = 0.13;
    let joint = (stem / CORE).asin();
    let back = -0.5 * (1.0 + INNER);
    vec![
        line(vec2(0.0, back), vec2(stem, back), 1),
        line(vec2(stem, back), vec2(stem, -CORE * joint.cos()), 3),
        arc(Vec2::ZERO, CORE, -FRAC_PI_2 + joint, FRAC_PI_2, 32),
    ]
}

/// Section of the ring: rounded, wider at the foot, its upper inner edge in touch with the shell.
fn ring_profile() -> Vec<Vec2> {
    let bead = |centre: Vec2, radius: f32, from: f32, to: f32| arc(centre, radius, from * TAU, to * TAU, 5);
    let mut section = Vec::new();
    section.extend(bead(vec2(0.72, 0.04), 0.04, -0.25, 0.10));
    section.extend(bead(vec2(0.60, 0.24), 0.035, 0.10, 0.45));
    section.extend(bead(vec2(0.50, 0.04), 0.04, 0.45, 0.75));
    section
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn all_pieces_are_closed() {
        let ball = shader_ball(0.1);
        for piece in [&ball.shell, &ball.core, &ball.ring] {
            assert_sound(piece);
            assert_closed(piece);
        }
        assert!(ball.ring.lowest().abs() < 1e-6);
    }

    #[test]
    fn the_ring_holds_the_shell_without_gap() {
        let centre = vec2(0.0, CENTRE);
        let nearest = ring_profile().iter().map(|p| p.distance(centre)).fold(f32::INFINITY, f32::min);
        assert!((0.97..1.0).contains(&nearest), "{nearest}");
    }
}
