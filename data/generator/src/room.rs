//! The shell of the interior: slabs and walls of real thickness, closed except for one window.

use glam::{Vec3, vec2, vec3};

use crate::mesh::Mesh;
use crate::rounded_box::{plain_box, rounded_box};

/// Inner half width (X), height and half depth (Z) of the room in meters.
pub const HALF_WIDTH: f32 = 2.3;
/// Clear height in meters.
pub const HEIGHT: f32 = 2.6;
/// Inner half depth in meters.
pub const HALF_DEPTH: f32 = 2.0;
/// Thickness of walls and slabs in meters.
const WALL: f32 = 0.18;
/// Cells of the walls: large, because tessellation follows later.
const CELL: f32 = 0.35;
/// Window in the wall at -X: lower and upper corner as (z, y).
pub const WINDOW: [glam::Vec2; 2] = [vec2(-1.15, 0.70), vec2(0.75, 2.20)];

/// A box between two corners.
fn between(low: Vec3, high: Vec3) -> Mesh {
    plain_box(high - low, CELL).shifted(0.5 * (low + high))
}

/// The floor slab; texture coordinates are meters.
pub fn floor() -> Mesh {
    between(vec3(-HALF_WIDTH - WALL, -WALL, -HALF_DEPTH - WALL), vec3(HALF_WIDTH + WALL, 0.0, HALF_DEPTH + WALL))
}

/// The ceiling slab.
pub fn ceiling() -> Mesh {
    let low = vec3(-HALF_WIDTH - WALL, HEIGHT, -HALF_DEPTH - WALL);
    between(low, vec3(HALF_WIDTH + WALL, HEIGHT + WALL, HALF_DEPTH + WALL))
}

/// The four walls as abutting boxes; the one at -X is built of four around its window.
pub fn walls() -> Vec<Mesh> {
    let (x, z) = (HALF_WIDTH, HALF_DEPTH);
    let [low, high] = WINDOW;
    let left = |z0: f32, z1: f32, y0: f32, y1: f32| between(vec3(-x - WALL, y0, z0), vec3(-x, y1, z1));
    vec![
        between(vec3(x, 0.0, -z), vec3(x + WALL, HEIGHT, z)),
        between(vec3(-x - WALL, 0.0, -z - WALL), vec3(x + WALL, HEIGHT, -z)),
        between(vec3(-x - WALL, 0.0, z), vec3(x + WALL, HEIGHT, z + WALL)),
        left(-z, low.x, 0.0, HEIGHT),
        left(high.x, z, 0.0, HEIGHT),
        left(low.x, high.x, 0.0, low.y),
        left(low.x, high.x, high.y, HEIGHT),
    ]
}

/// Frame, mullions and sill of the window.
pub fn window_frame() -> Vec<Mesh> {
    let [low, high] = WINDOW;
    let x = -HALF_WIDTH - 0.6 * WALL;
    let middle = 0.5 * (low + high);
    let size = high - low;
    let upright = |z: f32, width: f32| rounded_box(vec3(0.06, size.y, width), 0.006, 0.3).shifted(vec3(x, middle.y, z));
    let across = |y: f32, width: f32| rounded_box(vec3(0.055, width, size.x), 0.006, 0.3).shifted(vec3(x, y, middle.x));
    let sill = rounded_box(vec3(0.24, 0.03, size.x + 0.16), 0.008, 0.2);
    vec![
        upright(low.x + 0.03, 0.06),
        upright(high.x - 0.03, 0.06),
        upright(low.x + size.x / 3.0, 0.035),
        upright(high.x - size.x / 3.0, 0.035),
        across(low.y + 0.03, 0.06),
        across(high.y - 0.03, 0.06),
        across(low.y + 0.62 * size.y, 0.035),
        sill.shifted(vec3(-HALF_WIDTH + 0.03, low.y - 0.002, middle.x)),
    ]
}

/// Skirting boards along three walls, a hair's breadth inside them.
pub fn skirting() -> Vec<Mesh> {
    let (x, z) = (HALF_WIDTH, HALF_DEPTH);
    let (height, depth) = (0.09, 0.016);
    let board = |centre: Vec3, size: Vec3| rounded_box(size, 0.004, 0.4).shifted(centre);
    vec![
        board(vec3(0.0, 0.5 * height, -z + 0.4 * depth), vec3(2.0 * x, height, depth)),
        board(vec3(x - 0.4 * depth, 0.5 * height, 0.0), vec3(depth, height, 2.0 * z - 2.0 * depth)),
        board(vec3(-x + 0.4 * depth, 0.5 * height, 0.0), vec3(depth, height, 2.0 * z - 2.0 * depth)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn the_shell_is_closed() {
        let mut parts = vec![floor(), ceiling()];
        parts.extend(walls());
        parts.extend(window_frame());
        parts.extend(skirting());
        for part in &parts {
            assert_sound(part);
            assert_closed(part);
        }
    }

    #[test]
    fn light_enters_only_by_the_window() {
        let parts: Vec<Mesh> = [vec![floor(), ceiling()], walls()].concat();
        let inside = |p: Vec3| parts.iter().any(|part| in_bounds(part, p));
        let [low, high] = WINDOW;
        for k in 0..4000 {
            let d = sphere_direction(k, 4000);
            let at = out_through_wall(vec3(0.1, 1.3, 0.05), d);
            let in_window = at.x < -HALF_WIDTH && (low.x..high.x).contains(&at.z) && (low.y..high.y).contains(&at.y);
            assert_eq!(inside(at), !in_window, "{at}");
        }
    }

    fn in_bounds(part: &Mesh, p: Vec3) -> bool {
        let low = part.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = part.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        p.cmpge(low).all() && p.cmple(high).all()
    }

    fn sphere_direction(k: usize, count: usize) -> Vec3 {
        let y = 1.0 - (2 * k + 1) as f32 / count as f32;
        let angle = k as f32 * 2.399_963;
        let r = (1.0 - y * y).sqrt();
        vec3(r * angle.cos(), y, r * angle.sin())
    }

    /// The point a centimeter behind the inner surface of floor, ceiling or wall.
    fn out_through_wall(from: Vec3, d: Vec3) -> Vec3 {
        let (low, high) = (vec3(-HALF_WIDTH, 0.0, -HALF_DEPTH), vec3(HALF_WIDTH, HEIGHT, HALF_DEPTH));
        let times = ((low - from) / d).max((high - from) / d);
        let at = from + d * times.min_element();
        at + 0.01 * (at - at.clamp(low + 1e-4, high - 1e-4)).normalize()
    }
}
