//! An openwork lantern: two families of strips wind around an onion-shaped body and cross, so the sun casts a net of
//! light behind it.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Vec2, Vec3, vec2};

use crate::curve::{arc, through};
use crate::mesh::Mesh;
use crate::tube::{Station, sweep_open};
use crate::turned::{turn, turn_loop};

/// Strips per family.
const STRIPS: usize = 14;
/// Turns of each strip from foot to cap.
const TURNS: f32 = 0.38;
/// Stations along a strip.
const STATIONS: usize = 40;
/// Half thickness and half width of a strip, in lantern heights.
const SECTION: Vec2 = vec2(0.0055, 0.0115);

/// The lantern of `height` meters standing on `y = 0`; its parts overlap where metal would be soldered.
pub fn lantern(height: f32) -> Vec<Mesh> {
    let mut parts: Vec<Mesh> = Vec::new();
    for k in 0..STRIPS {
        let start = k as f32 / STRIPS as f32 * TAU;
        parts.push(strip(start, TURNS * TAU));
        parts.push(strip(start, -TURNS * TAU));
    }
    parts.extend(hoops());
    parts.extend([foot(), cap(), finial()]);
    for p in parts.iter_mut().flat_map(|part| &mut part.positions) {
        *p *= height;
    }
    parts
}

/// The lantern as one mesh.
pub fn joined(height: f32) -> Mesh {
    let mut all = Mesh::default();
    for part in lantern(height) {
        all.append(&part);
    }
    all
}

/// Body outline: distance from the axis and height, in lantern heights.
fn outline() -> Vec<Vec2> {
    let points = [
        vec2(0.190, 0.055),
        vec2(0.262, 0.130),
        vec2(0.312, 0.260),
        vec2(0.317, 0.390),
        vec2(0.268, 0.540),
        vec2(0.172, 0.670),
        vec2(0.098, 0.770),
        vec2(0.070, 0.850),
    ];
    let curve = through(&points, 24);
    evenly(&curve, STATIONS)
}

/// Picks `steps + 1` points at equal distances along a curve.
fn evenly(curve: &[Vec2], steps: usize) -> Vec<Vec2> {
    let total: f32 = curve.windows(2).map(|w| w[0].distance(w[1])).sum();
    let mut picked = vec![curve[0]];
    let mut travelled = 0.0;
    for w in curve.windows(2) {
        let step = w[0].distance(w[1]);
        while picked.len() < steps && travelled + step >= total * picked.len() as f32 / steps as f32 {
            let t = (total * picked.len() as f32 / steps as f32 - travelled) / step;
            picked.push(w[0].lerp(w[1], t));
        }
        travelled += step;
    }
    picked.push(curve[curve.len() - 1]);
    picked
}

fn strip(start: f32, sweep: f32) -> Mesh {
    let outline = outline();
    let last = outline.len() - 1;
    let station = |i: usize| {
        let p = outline[i];
        let slope = outline[(i + 1).min(last)] - outline[i.saturating_sub(1)];
        let angle = start + sweep * i as f32 / last as f32;
        let around = Vec3::new(angle.sin(), 0.0, angle.cos());
        Station {
            centre: around * p.x + Vec3::Y * p.y,
            outward: (around * slope.y - Vec3::Y * slope.x).normalize(),
            // Narrower toward the cap, where the strips crowd together.
            radii: SECTION * vec2(1.0, 0.45 + 0.55 * (p.x / 0.3).min(1.0)),
        }
    };
    let path: Vec<Station> = (0..=last).map(station).collect();
    sweep_open(&path, 6)
}

/// Rings around the body, on the strips' crossings' side.
fn hoops() -> Vec<Mesh> {
    let outline = outline();
    let hoop = |p: Vec2, radius: f32| {
        let mut section = arc(p, radius, 0.0, TAU, 8);
        section.pop();
        turn_loop(&section, 72)
    };
    vec![hoop(outline[STATIONS * 2 / 5], 0.010), hoop(outline[STATIONS * 7 / 10], 0.008)]
}

fn foot() -> Mesh {
    let bead = |centre: Vec2, radius: f32, from: f32, to: f32| arc(centre, radius, from * TAU, to * TAU, 4);
    let mut section = Vec::new();
    section.extend(bead(vec2(0.232, 0.012), 0.012, -0.25, 0.15));
    section.extend(bead(vec2(0.200, 0.062), 0.010, 0.10, 0.40));
    section.extend(bead(vec2(0.176, 0.012), 0.012, 0.45, 0.75));
    turn_loop(&section, 72)
}

fn cap() -> Mesh {
    let dome = [
        vec2(0.092, 0.835),
        vec2(0.094, 0.842),
        vec2(0.082, 0.866),
        vec2(0.050, 0.898),
        vec2(0.020, 0.912),
        vec2(0.0, 0.915),
    ];
    turn(&[vec![vec2(0.0, 0.835), vec2(0.046, 0.835), vec2(0.092, 0.835)], through(&dome, 3)], 40)
}

/// The upright carrying ring on top.
fn finial() -> Mesh {
    let (radius, wire, count) = (0.038, 0.0075, 32);
    let station = |k: usize| {
        let (sin, cos) = (k as f32 / count as f32 * TAU + FRAC_PI_2).sin_cos();
        let outward = Vec3::new(cos, sin, 0.0);
        Station { centre: outward * radius + Vec3::Y * (0.948), outward, radii: Vec2::splat(wire) }
    };
    let path: Vec<Station> = (0..count).map(station).collect();
    crate::tube::sweep_closed(&path, 8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn every_part_is_closed() {
        for part in lantern(0.3) {
            assert_sound(&part);
            assert_closed(&part);
        }
    }

    #[test]
    fn it_stands_on_the_floor() {
        assert!(joined(0.3).lowest().abs() < 1e-6);
    }
}
