//! Furniture for the interior, each piece standing on `y = 0` around the origin and facing +Z.
//!
//! Every function returns closed parts; parts touch or overlap where wood is joined.

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

use crate::curve::{arc, line, through};
use crate::mesh::Mesh;
use crate::noise::{lerp, unit};
use crate::rounded_box::{plain_box, rounded_box};
use crate::turned::{creased, turn};

/// Joins parts into one mesh.
pub fn joined(parts: Vec<Mesh>) -> Mesh {
    let mut all = Mesh::default();
    for part in &parts {
        all.append(part);
    }
    all
}

/// A rounded box by its center.
fn block(centre: Vec3, size: Vec3, radius: f32, cell: f32) -> Mesh {
    rounded_box(size, radius, cell).shifted(centre)
}

/// Upholstered parts of a sofa 1.9 m wide: base, arms, seat and back cushions.
pub fn sofa() -> Vec<Mesh> {
    let mut parts = vec![
        block(vec3(0.0, 0.22, 0.0), vec3(1.60, 0.18, 0.82), 0.03, 0.2),
        block(vec3(0.0, 0.50, -0.36), vec3(1.62, 0.52, 0.14), 0.05, 0.2),
    ];
    for side in [-1.0, 1.0] {
        parts.push(block(vec3(side * 0.87, 0.36, 0.0), vec3(0.16, 0.46, 0.86), 0.06, 0.24));
        parts.push(block(vec3(side * 0.395, 0.385, 0.07), vec3(0.775, 0.16, 0.68), 0.055, 0.17));
        let leaning =
            Affine3A::from_rotation_translation(Quat::from_rotation_x(-0.22), vec3(side * 0.395, 0.64, -0.20));
        parts.push(rounded_box(vec3(0.76, 0.40, 0.17), 0.07, 0.17).moved(leaning));
    }
    parts
}

/// The sofa's turned feet.
pub fn sofa_feet() -> Vec<Mesh> {
    let foot = leg(0.15, 0.016, 0.024);
    let corners = [(-0.82, -0.34), (0.82, -0.34), (-0.82, 0.34), (0.82, 0.34)];
    corners.map(|(x, z)| foot.clone().shifted(vec3(x, 0.0, z))).to_vec()
}

/// Two loose cushions that lie against the sofa's back.
pub fn cushions() -> Vec<Mesh> {
    let plump = |centre: Vec3, turn: f32, tilt: f32| {
        let placed =
            Affine3A::from_rotation_translation(Quat::from_rotation_y(turn) * Quat::from_rotation_x(tilt), centre);
        pillow(0.42, 0.13).moved(placed)
    };
    vec![plump(vec3(-0.56, 0.645, 0.015), 0.25, -0.34), plump(vec3(0.55, 0.645, 0.02), -0.30, -0.36)]
}

/// A square pillow: thick in the middle, thin toward its seam.
fn pillow(side: f32, thickness: f32) -> Mesh {
    let mut mesh = rounded_box(vec3(side, side, thickness), 0.4 * thickness, 0.055);
    for p in &mut mesh.positions {
        let edge = (p.x.abs() / (0.5 * side)).powi(4) + (p.y.abs() / (0.5 * side)).powi(4);
        p.z *= 1.0 - 0.62 * edge.min(1.0);
        // The sides draw in between the corners.
        let pull = |along: f32| 1.0 - 0.07 * (1.0 - (2.0 * along / side).powi(2));
        (p.x, p.y) = (p.x * pull(p.y), p.y * pull(p.x));
    }
    mesh.smooth_normals();
    mesh
}

/// A round leg that widens from `foot` to `top` radius.
fn leg(height: f32, foot: f32, top: f32) -> Mesh {
    let profile = creased(&[vec2(0.0, 0.0), vec2(foot, 0.0), vec2(top, height), vec2(0.0, height)]);
    let mut mesh = turn(&profile, 12);
    // Grain runs along U: rotate it to run along the leg.
    for uv in &mut mesh.uvs {
        *uv = vec2(uv.y, 0.2 * uv.x);
    }
    mesh
}

/// A leg that leans from the floor at `foot` to `top`.
fn leaning_leg(foot: Vec3, top: Vec3, radius: f32) -> Mesh {
    let height = top.y - foot.y;
    let lean = (top - foot).with_y(0.0) / height;
    let mut mesh = leg(height, 0.7 * radius, radius);
    // Sheared, not rotated: the foot stays flat on the floor.
    for (p, n) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        *p += lean * p.y + foot;
        *n = (*n - Vec3::Y * lean.dot(*n)).normalize();
    }
    mesh
}

/// A low table with a round top of 0.9 m and three leaning legs.
pub fn coffee_table() -> Vec<Mesh> {
    let mut edge = vec![vec![vec2(0.0, 0.385), vec2(0.22, 0.385), vec2(0.42, 0.385)]];
    edge.push(through(&[vec2(0.42, 0.385), vec2(0.447, 0.402), vec2(0.450, 0.412), vec2(0.442, 0.418)], 2));
    edge.push(vec![vec2(0.442, 0.418), vec2(0.30, 0.418), vec2(0.15, 0.418), vec2(0.0, 0.418)]);
    let mut top = turn(&edge, 48);
    // A board, not a log: the texture lies flat on it.
    for (uv, p) in top.uvs.iter_mut().zip(&top.positions) {
        *uv = vec2(p.x, p.z + p.y);
    }
    let mut parts = vec![top];
    for k in 0..3 {
        let out = Quat::from_rotation_y(k as f32 * 2.0 * std::f32::consts::FRAC_PI_3 + 0.4) * Vec3::Z;
        parts.push(leaning_leg(out * 0.40, out * 0.27 + Vec3::Y * 0.39, 0.024));
    }
    parts
}

/// A wooden chair with a back of slats, 0.46 m seat height.
pub fn chair() -> Vec<Mesh> {
    let mut parts = vec![block(vec3(0.0, 0.445, 0.0), vec3(0.44, 0.035, 0.43), 0.014, 0.15)];
    for side in [-1.0, 1.0] {
        parts.push(leaning_leg(vec3(side * 0.205, 0.0, 0.195), vec3(side * 0.180, 0.44, 0.175), 0.019));
        parts.push(leaning_leg(vec3(side * 0.205, 0.0, -0.235), vec3(side * 0.185, 0.44, -0.180), 0.019));
        parts.push(leaning_leg(vec3(side * 0.185, 0.44, -0.185), vec3(side * 0.190, 0.90, -0.265), 0.017));
    }
    for k in 0..5 {
        let x = 0.066 * (k as f32 - 2.0);
        parts.push(leaning_leg(vec3(x, 0.455, -0.185), vec3(x * 1.05, 0.86, -0.258), 0.009));
    }
    let rail = Affine3A::from_rotation_translation(Quat::from_rotation_x(-0.17), vec3(0.0, 0.875, -0.262));
    parts.push(rounded_box(vec3(0.43, 0.075, 0.022), 0.009, 0.12).moved(rail));
    parts
}

/// Height, width and depth of the shelf, and the height of one compartment.
const SHELF: Vec3 = vec3(0.95, 1.86, 0.28);
const COMPARTMENT: f32 = 0.365;
const BOARD: f32 = 0.024;

/// The shelf's boards, with the back toward -Z.
pub fn shelf() -> Vec<Mesh> {
    let upright = vec3(BOARD, SHELF.y, SHELF.z);
    let x = 0.5 * (SHELF.x - BOARD);
    let mut parts = vec![
        block(vec3(-x, 0.5 * SHELF.y, 0.0), upright, 0.003, 0.2),
        block(vec3(x, 0.5 * SHELF.y, 0.0), upright, 0.003, 0.2),
        block(
            vec3(0.0, 0.5 * SHELF.y, 0.008 - 0.5 * SHELF.z),
            vec3(SHELF.x - BOARD, SHELF.y - 0.01, 0.010),
            0.002,
            0.2,
        ),
    ];
    for level in 0..6 {
        let board = vec3(SHELF.x - 1.5 * BOARD, BOARD, SHELF.z - 0.02);
        parts.push(block(vec3(0.0, board_top(level) - 0.5 * BOARD, 0.004), board, 0.003, 0.16));
    }
    parts
}

/// Height of the upper side of a board.
pub fn board_top(level: usize) -> f32 {
    0.03 + COMPARTMENT * level as f32
}

/// Books in `colors` groups, one mesh per color: in rows on four of the boards, some leaning.
pub fn books(colors: usize) -> Vec<Vec<Mesh>> {
    let mut heaps = vec![Vec::new(); colors];
    let rows = [(0, -0.43, 0.40), (1, -0.43, 0.10), (2, -0.05, 0.42), (3, -0.43, 0.22), (4, 0.02, 0.40)];
    for (level, from, to) in rows {
        let mut x = from;
        let mut k = 0;
        while x < to {
            let (book, width) = book(level, k, x);
            let color = unit(level as i32, k, 203) * colors as f32;
            heaps[color as usize].push(book);
            x += width + 0.0015;
            k += 1;
        }
    }
    heaps
}

fn book(level: usize, k: i32, x: f32) -> (Mesh, f32) {
    let random = |seed| unit(level as i32, k, seed);
    let size = vec3(lerp(0.016, 0.046, random(200)), lerp(0.19, 0.29, random(201)), lerp(0.14, 0.20, random(202)));
    let centre = vec3(x + 0.5 * size.x, board_top(level) + 0.5 * size.y, 0.11 - 0.5 * size.z + 0.01 * random(204));
    (plain_box(size, 0.2).shifted(centre), size.x)
}

/// A stack of lying books for a table, from large to small.
pub fn book_stack() -> Vec<Mesh> {
    let sizes = [vec3(0.26, 0.032, 0.19), vec3(0.23, 0.024, 0.165), vec3(0.19, 0.028, 0.13)];
    let mut height = 0.0;
    let mut parts = Vec::new();
    for (k, size) in sizes.into_iter().enumerate() {
        let turned = Quat::from_rotation_y(0.3 - 0.25 * k as f32);
        let placed = Affine3A::from_rotation_translation(turned, Vec3::Y * (height + 0.5 * size.y));
        parts.push(rounded_box(size, 0.003, 0.1).moved(placed));
        height += size.y;
    }
    parts
}

/// Picture frame around a canvas of `width` by `height`, with its back toward -Z at `z = 0` and its center at the origin.
pub fn frame(width: f32, height: f32) -> Vec<Mesh> {
    let (bar, depth) = (0.035, 0.030);
    let mut parts = Vec::new();
    for side in [-1.0, 1.0] {
        let across = vec3(width + 2.0 * bar, bar, depth);
        let up = vec3(bar, height, depth);
        parts.push(block(vec3(0.0, side * 0.5 * (height + bar), 0.5 * depth), across, 0.006, 0.2));
        parts.push(block(vec3(side * 0.5 * (width + bar), 0.0, 0.5 * depth), up, 0.006, 0.2));
    }
    parts
}

/// The canvas for [`frame`]; its front shows one texture once.
pub fn canvas(width: f32, height: f32) -> Mesh {
    plain_box(vec3(width, height, 0.012), 0.15).tiled(vec2(1.0 / width, 1.0 / height)).shifted(Vec3::Z * 0.008)
}

/// Foot and pole of a floor lamp.
pub fn lamp_stand() -> Vec<Mesh> {
    let foot = [vec2(0.150, 0.006), vec2(0.149, 0.014), vec2(0.120, 0.022), vec2(0.030, 0.030), vec2(0.012, 0.050)];
    let mut profile = creased(&[vec2(0.0, 0.0), vec2(0.144, 0.0), vec2(0.150, 0.006)]);
    profile.push(through(&foot, 3));
    profile.push((0..=4).map(|k| vec2(0.012, 0.050 + k as f32 * 0.34)).collect());
    profile.extend(creased(&[vec2(0.012, 1.41), vec2(0.022, 1.42), vec2(0.022, 1.46), vec2(0.0, 1.46)]));
    vec![turn(&profile, 24)]
}

/// The lamp's shade: a thin shell, open above and below.
pub fn lamp_shade() -> Mesh {
    let (low, high, wall) = (vec2(0.235, 1.36), vec2(0.165, 1.66), vec2(0.004, 0.0));
    let profile =
        [line(low, high, 6), line(high, high - wall, 1), line(high - wall, low - wall, 6), line(low - wall, low, 1)];
    turn(&profile, 36)
}

/// The lamp's globe.
pub fn lamp_bulb() -> Mesh {
    turn(&[arc(vec2(0.0, 1.50), 0.055, -FRAC_PI_2, FRAC_PI_2, 12)], 18)
}

/// One curtain of `width` and `height`, hanging in folds; open, seen from both sides.
pub fn curtain(width: f32, height: f32, seed: f32) -> Mesh {
    let (columns, rows) = (90, 8);
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let uv = vec2(column as f32 / columns as f32, row as f32 / rows as f32);
            mesh.push(curtain_point(uv, width, height, seed), Vec3::Y, uv * vec2(2.0, 6.0));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            mesh.quad(a, a + columns + 1, a + columns + 2, a + 1);
        }
    }
    mesh.smooth_normals();
    mesh
}

/// Folds that open slowly toward the hem.
fn curtain_point(uv: Vec2, width: f32, height: f32, seed: f32) -> Vec3 {
    let phase = 34.0 * uv.x + 0.6 * (5.0 * uv.x + seed).sin() + 0.5 * (3.0 * uv.y + seed).sin();
    let depth = 0.022 + 0.022 * uv.y + 0.008 * (9.0 * uv.x + seed).sin();
    let spread = 1.0 + 0.06 * uv.y;
    vec3((uv.x - 0.5) * width * spread + 0.0015 * (2.0 * phase).sin(), height * (1.0 - uv.y), depth * phase.sin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn every_part_is_closed() {
        let mut parts = vec![canvas(0.9, 0.6), lamp_shade(), lamp_bulb()];
        let groups = [
            sofa(),
            sofa_feet(),
            cushions(),
            coffee_table(),
            chair(),
            shelf(),
            book_stack(),
            frame(0.9, 0.6),
            lamp_stand(),
        ];
        parts.extend(groups.into_iter().flatten());
        parts.extend(books(3).into_iter().flatten());
        for part in &parts {
            assert_sound(part);
            assert_closed(part);
        }
    }

    #[test]
    fn furniture_stands_on_the_floor() {
        for piece in [sofa_feet(), coffee_table(), chair(), lamp_stand()] {
            let lowest = joined(piece).lowest();
            assert!(lowest.abs() < 0.02, "{lowest}");
        }
    }

    #[test]
    fn the_curtain_is_sound() {
        assert_sound(&curtain(0.5, 2.2, 0.0));
    }
}
