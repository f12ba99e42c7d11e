//! A warm room with one large window and a lamp, seen from its middle: the map for soft one-sided light.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, vec2, vec3};

use crate::environment::Environment;
use crate::noise::{fractal, smoothstep};

/// Half extents of the room around the viewpoint, meters.
const HALF: Vec3 = vec3(2.3, 1.35, 2.6);
/// Lower and upper corner of the window in the wall at -X: (z, y).
const WINDOW: [Vec2; 2] = [vec2(-1.45, -0.40), vec2(0.85, 1.05)];
/// Panes across and up.
const PANES: Vec2 = vec2(3.0, 2.0);
/// Half width of a mullion in meters.
const MULLION: f32 = 0.028;
/// Direction of the low sun outside.
const TOWARDS_SUN: Vec3 = vec3(-0.80, 0.52, -0.30);
/// Radiance times pi of a white sunlit surface.
const SUN: Vec3 = vec3(21.0, 17.5, 12.5);
/// Lamp: center, radius, radiance.
const LAMP: Vec3 = vec3(1.55, 0.12, 1.75);
const LAMP_RADIUS: f32 = 0.17;
const LAMP_RADIANCE: Vec3 = vec3(15.0, 9.0, 4.2);
/// Light after more than one bounce, as uniform radiance.
const BOUNCED: Vec3 = vec3(0.30, 0.245, 0.19);

/// The window-lit map.
pub fn window_room() -> Environment {
    Environment::paint(radiance).scaled_to_mean(1.0)
}

fn radiance(d: Vec3) -> Vec3 {
    if let Some(cosine) = lamp_facing(d) {
        return LAMP_RADIANCE * (0.55 + 0.45 * cosine);
    }
    let (point, normal) = wall_hit(d);
    match window_part(point, normal) {
        WindowPart::Pane => outside(d),
        WindowPart::Frame => vec3(0.60, 0.57, 0.52) * lit(point, normal),
        WindowPart::None => albedo(point, normal) * lit(point, normal),
    }
}

/// The point where a ray from the viewpoint leaves the room, and the inward normal there.
fn wall_hit(d: Vec3) -> (Vec3, Vec3) {
    let times = HALF / d.abs().max(Vec3::splat(1e-6));
    let nearest = times.min_element();
    let axis = if times.x == nearest {
        0
    } else if times.y == nearest {
        1
    } else {
        2
    };
    (d * nearest, -d[axis].signum() * Vec3::AXES[axis])
}

fn lamp_facing(d: Vec3) -> Option<f32> {
    let closest = d * d.dot(LAMP).max(0.0);
    let miss = closest.distance(LAMP) / LAMP_RADIUS;
    (miss < 1.0).then(|| (1.0 - miss * miss).sqrt())
}

#[derive(PartialEq)]
enum WindowPart {
    None,
    Pane,
    Frame,
}

fn window_part(point: Vec3, normal: Vec3) -> WindowPart {
    if normal != Vec3::X {
        return WindowPart::None;
    }
    let size = WINDOW[1] - WINDOW[0];
    let at = vec2(point.z, point.y) - WINDOW[0];
    if at.min_element() < -2.0 * MULLION || (at - size).max_element() > 2.0 * MULLION {
        return WindowPart::None;
    }
    let pane = size / PANES;
    let to_bar = (at - (at / pane).round() * pane).abs().min_element();
    if to_bar < MULLION || at.min_element() < 0.0 || (at - size).max_element() > 0.0 {
        WindowPart::Frame
    } else {
        WindowPart::Pane
    }
}

/// The view through the glass: hazy sky over a garden.
fn outside(d: Vec3) -> Vec3 {
    let sky = vec3(9.5, 10.3, 11.2).lerp(vec3(5.5, 7.2, 9.8), smoothstep(0.0, 0.6, d.y));
    let leaves = 0.5 + 0.5 * fractal(vec2(0.5 + d.z / 4.0, 0.5 + d.y / 4.0), (24, 24), 3, 5);
    let garden = vec3(0.75, 0.95, 0.42) * (0.4 + 1.2 * leaves);
    let hedge = -0.03 + 0.10 * (leaves - 0.5);
    garden.lerp(sky, smoothstep(hedge - 0.02, hedge + 0.02, d.y))
}

/// Paint, boards, a picture and a dark shelf, in a few strokes.
fn albedo(point: Vec3, normal: Vec3) -> Vec3 {
    let grain = fractal(vec2(0.5 + point.x / 8.0, 0.5 + point.z / 8.0), (2, 40), 3, 17);
    if normal == Vec3::Y {
        let board = ((point.x + 8.0) / 0.16).fract();
        let gap = smoothstep(0.0, 0.03, board.min(1.0 - board));
        return vec3(0.26, 0.15, 0.08) * (1.0 + 0.25 * grain) * (0.4 + 0.6 * gap);
    }
    if normal == Vec3::NEG_Y {
        return vec3(0.74, 0.70, 0.64);
    }
    let inside = |low: Vec2, high: Vec2, at: Vec2| at.cmpge(low).all() && at.cmple(high).all();
    let across = vec2(if normal.x != 0.0 { point.z } else { point.x }, point.y);
    if normal == Vec3::NEG_X && inside(vec2(-2.2, -1.35), vec2(-0.7, 0.75), across) {
        let books = fractal(vec2(0.5 + across.x / 4.0, (across.y + 2.0) / 0.42 % 1.0 * 0.01), (60, 1), 1, 29);
        let shelf = ((across.y + 1.35) / 0.42).fract();
        return if shelf < 0.08 { vec3(0.10, 0.06, 0.03) } else { vec3(0.16, 0.09, 0.06) * (1.0 + 0.8 * books) };
    }
    if normal == Vec3::NEG_Z && inside(vec2(-0.9, -0.1), vec2(0.5, 0.85), across) {
        let canvas = inside(vec2(-0.84, -0.04), vec2(0.44, 0.79), across);
        return if canvas { vec3(0.20, 0.26, 0.27) * (1.0 + 0.5 * grain) } else { vec3(0.30, 0.20, 0.08) };
    }
    let skirting = point.y < -HALF.y + 0.12;
    if skirting { vec3(0.66, 0.61, 0.54) } else { vec3(0.63, 0.52, 0.40) }
}

/// Irradiance over pi at a point of the room.
fn lit(point: Vec3, normal: Vec3) -> Vec3 {
    BOUNCED + from_window(point, normal) + from_lamp(point, normal) + from_sun(point, normal)
}

fn from_window(point: Vec3, normal: Vec3) -> Vec3 {
    let (columns, rows) = (6, 4);
    let size = WINDOW[1] - WINDOW[0];
    let area = size.x * size.y / (columns * rows) as f32;
    let patches = (0..columns * rows).map(|k| {
        let at = WINDOW[0]
            + size * vec2((k % columns) as f32 + 0.5, (k / columns) as f32 + 0.5) / vec2(columns as f32, rows as f32);
        let to = vec3(-HALF.x, at.y, at.x) - point;
        // Bounded below: a wall point beside the window would see a patch at distance zero.
        let distance_sq = to.length_squared().max(0.05);
        let towards = to / distance_sq.sqrt();
        let cosines = normal.dot(towards).max(0.0) * (-towards.x).max(0.0);
        vec3(6.8, 8.0, 9.2) * (cosines * area / distance_sq)
    });
    patches.sum::<Vec3>() / PI
}

fn from_lamp(point: Vec3, normal: Vec3) -> Vec3 {
    let to = LAMP - point;
    let distance_sq = to.length_squared().max(LAMP_RADIUS * LAMP_RADIUS);
    let solid_angle = PI * LAMP_RADIUS * LAMP_RADIUS / distance_sq;
    LAMP_RADIANCE * (normal.dot(to.normalize()).max(0.0) * solid_angle / PI)
}

/// Sun through the panes: the bright patches on floor and walls.
fn from_sun(point: Vec3, normal: Vec3) -> Vec3 {
    let towards = TOWARDS_SUN.normalize();
    let time = (-HALF.x - point.x) / towards.x;
    let cosine = normal.dot(towards);
    if time <= 1e-3 || cosine <= 0.0 || window_part(point + towards * time, Vec3::X) != WindowPart::Pane {
        return Vec3::ZERO;
    }
    SUN * (cosine / PI)
}
