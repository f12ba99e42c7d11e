//! The patterns of the bundle, each a function of texture coordinates that tiles on the unit square.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};

use crate::noise::{cells, fractal, gradient, lerp, smoothstep, unit};

/// Walnut, grain along U. Linear base color.
pub fn walnut(uv: Vec2) -> Vec3 {
    grain(uv, [vec3(0.050, 0.024, 0.013), vec3(0.185, 0.098, 0.052)], 8, 21)
}

/// Oak, grain along U. Linear base color.
pub fn oak(uv: Vec2) -> Vec3 {
    grain(uv, [vec3(0.235, 0.135, 0.066), vec3(0.430, 0.275, 0.150)], 9, 57)
}

/// Wood: year rings cut lengthwise, varied by slow noise, over fine fibers and pores.
fn grain(uv: Vec2, [dark, light]: [Vec3; 2], rings: i32, seed: u32) -> Vec3 {
    let wander = 0.055 * fractal(uv, (1, 2), 2, seed) + 0.006 * fractal(uv, (3, 16), 2, seed + 9);
    let phase = rings as f32 * (uv.y + wander);
    // Each ring darkens slowly towards its late wood and ends abruptly.
    let within = phase - phase.floor();
    let late = within.powi(2) * (1.0 - smoothstep(0.90, 1.0, within));
    let fibre = 0.5 + 0.5 * gradient(uv, (6, 160), seed + 3);
    let streak = 0.5 + 0.5 * fractal(uv, (2, 14), 3, seed + 5);
    let tone = (0.85 - 0.75 * late + 0.45 * (streak - 0.5) + 0.30 * (fibre - 0.5)).clamp(0.0, 1.0);
    dark.lerp(light, tone) * (1.0 - 0.45 * pore(uv, seed + 7))
}

/// Short dark dashes along the grain.
fn pore(uv: Vec2, seed: u32) -> f32 {
    let (columns, rows) = (24, 128);
    let at = vec2(uv.x * columns as f32, uv.y * rows as f32);
    let row = (at.y.floor() as i32).rem_euclid(rows);
    let at = vec2(at.x + unit(row, 0, seed) * columns as f32, at.y);
    let column = (at.x.floor() as i32).rem_euclid(columns);
    let there = if unit(column, row, seed + 1) < 0.22 { 1.0 } else { 0.0 };
    let along = at.x.fract();
    there * smoothstep(0.0, 0.2, along) * (1.0 - smoothstep(0.5, 0.9, along)) * (TAU * 0.5 * at.y.fract()).sin()
}

/// Oak boards, [`BOARDS`] of them side by side along U. Linear base color.
pub fn boards(uv: Vec2) -> Vec3 {
    let row = (uv.y * BOARDS as f32).floor() as i32;
    let within = uv.y * BOARDS as f32 - row as f32;
    // Two boards per row, each row shifted by its own amount.
    let along = uv.x * 2.0 + unit(row, 1, 101);
    let board = row * 2 + (along.floor() as i32).rem_euclid(2);
    let shifted = vec2(uv.x + unit(board, 2, 102), (within + board as f32) / BOARDS as f32);
    let gap = within.min(1.0 - within).min(4.0 * (along.fract()).min(1.0 - along.fract()));
    let tone = lerp(0.72, 1.12, unit(board, 3, 103)) * lerp(0.35, 1.0, smoothstep(0.0, 0.03, gap));
    oak(shifted - shifted.floor()) * tone
}

/// Rows of boards across the unit square of [`boards`].
const BOARDS: i32 = 8;

/// A woven rug: a field of lozenges in a border. Linear base color; covers the rug once.
pub fn rug(uv: Vec2) -> Vec3 {
    let [ground, rust, ink, cream] =
        [vec3(0.30, 0.085, 0.050), vec3(0.44, 0.20, 0.095), vec3(0.035, 0.050, 0.085), vec3(0.56, 0.49, 0.37)];
    // Knots: each knot has one color.
    let knots = vec2(180.0, 126.0);
    let at = ((uv * knots).floor() + 0.5) / knots;
    let hem = (at.x.min(1.0 - at.x) * 1.43).min(at.y.min(1.0 - at.y));
    let lozenge = |scale: Vec2| {
        let p = (at * scale - (at * scale).floor() - 0.5).abs();
        p.x + p.y
    };
    let field = lozenge(vec2(7.0, 5.0));
    let color = if hem < 0.035 {
        ink
    } else if hem < 0.115 {
        if lozenge(vec2(26.0, 18.0)) < 0.28 { cream } else { rust }
    } else if hem < 0.135 {
        ink
    } else if field < 0.14 {
        cream
    } else if field < 0.24 {
        ink
    } else if (0.42..0.50).contains(&field) {
        rust
    } else {
        ground
    };
    let pile = 0.5 + 0.5 * gradient(uv, (120, 84), 111);
    color * (0.82 + 0.18 * pile) * (1.0 + 0.12 * fractal(uv, (3, 3), 3, 112))
}

/// A painting: hills in evening haze. Linear base color; covers the canvas once.
pub fn painting(uv: Vec2) -> Vec3 {
    let sky = vec3(0.62, 0.36, 0.19).lerp(vec3(0.16, 0.24, 0.30), smoothstep(0.55, 0.0, uv.y));
    let mut color = sky * (1.0 + 0.10 * fractal(uv, (2, 7), 3, 121));
    for hill in 0..5 {
        let depth = hill as f32 / 4.0;
        let ridge = 0.46 + 0.10 * hill as f32 + 0.075 * fractal(vec2(uv.x, 0.3), (2 + hill, 2), 4, 131 + hill as u32);
        let haze = vec3(0.50, 0.33, 0.22).lerp(vec3(0.030, 0.055, 0.050), depth.sqrt());
        color = color.lerp(haze, smoothstep(ridge, ridge + 0.008, uv.y));
    }
    let sun = (uv - vec2(0.66, 0.36)) * vec2(1.45, 1.0);
    let in_sky = 1.0 - smoothstep(0.44, 0.46, uv.y);
    color = color.lerp(vec3(0.90, 0.62, 0.30), in_sky * (1.0 - smoothstep(0.045, 0.05, sun.length())));
    let brush = fractal(uv, (40, 90), 2, 141);
    color * (1.0 + 0.10 * brush)
}

/// Sofa cloth in a muted sage, its weave visible. Linear base color.
pub fn upholstery(uv: Vec2) -> Vec3 {
    let mixed = 0.5 + 0.5 * gradient(uv, (96, 96), 151);
    vec3(0.155, 0.185, 0.150) * (0.62 + 0.40 * weave(uv) + 0.16 * mixed)
}

/// Threads across the unit square of [`weave`].
pub const THREADS: i32 = 48;

/// Plain weave: height in [0, 1] of the thread on top.
pub fn weave(uv: Vec2) -> f32 {
    let at = uv * THREADS as f32;
    let (column, row) = (at.x.floor() as i32, at.y.floor() as i32);
    let over = (column + row).rem_euclid(2) == 0;
    let (across, along) = if over { (at.x.fract(), at.y.fract()) } else { (at.y.fract(), at.x.fract()) };
    let round = (across * TAU * 0.5).sin();
    let arch = (along * TAU * 0.5).sin();
    round.sqrt() * (0.45 + 0.55 * arch)
}

/// Undyed linen, uneven in thickness and tone. Linear base color.
pub fn linen(uv: Vec2) -> Vec3 {
    vec3(0.60, 0.535, 0.435) * linen_tone(uv, 1)
}

fn linen_tone(uv: Vec2, scale: i32) -> f32 {
    let tiled = uv * scale as f32;
    let slub_x = gradient(uv, (5 * scale, 60 * scale), 31);
    let slub_y = gradient(uv, (60 * scale, 5 * scale), 32);
    0.80 + 0.20 * weave(tiled - tiled.floor()) + 0.08 * slub_x + 0.08 * slub_y
}

/// A whole cloth with woven bands along its hems. Linear base color; covers the cloth once.
pub fn banded_cloth(uv: Vec2) -> Vec3 {
    let hem = uv.min(1.0 - uv);
    let bands = band(hem.x).max(band(hem.y));
    let tone = linen_tone(uv, 3);
    vec3(0.640, 0.585, 0.490).lerp(vec3(0.052, 0.082, 0.150), 0.94 * bands) * tone
}

/// One broad and two thin bands near the hem.
fn band(hem: f32) -> f32 {
    let stripe = |from: f32, to: f32| if (from..to).contains(&hem) { 1.0f32 } else { 0.0 };
    stripe(0.050, 0.056).max(stripe(0.066, 0.100)).max(stripe(0.110, 0.116))
}

/// A painter's backdrop: broad clouds of warm gray. Linear base color; covers the sweep once.
pub fn painted_canvas(uv: Vec2) -> Vec3 {
    let broad = 0.5 + 0.5 * fractal(uv, (3, 3), 4, 41);
    let brushed = 0.5 + 0.5 * fractal(uv, (18, 18), 2, 47);
    let tone = (0.75 * broad + 0.25 * brushed).clamp(0.0, 1.0);
    vec3(0.190, 0.168, 0.148).lerp(vec3(0.325, 0.296, 0.266), tone)
}

/// Overlapping dents of a planishing hammer: height in [0, 1].
pub fn hammered(uv: Vec2, dents: i32) -> f32 {
    let (near, _) = cells(uv, dents, 0.75, 61);
    let dent = (near * near * 1.1).min(1.0);
    (dent + 0.05 * fractal(uv, (8, 8), 3, 66)).clamp(0.0, 1.0)
}

/// Interlaced circles cut into a surface: height in [0, 1], 1 is the uncut ground.
pub fn engraved(uv: Vec2) -> f32 {
    let mut height = 1.0f32;
    for (dx, dy) in [(0.0, 0.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.5)] {
        let repeated = uv * 4.0 + vec2(dx, dy);
        let from_centre = repeated - repeated.round();
        let radius = from_centre.length();
        height = height.min(groove(radius - 0.353_553)).min(groove(radius - 0.09));
    }
    height
}

/// A rounded groove around `distance = 0`.
fn groove(distance: f32) -> f32 {
    1.0 - (1.0 - smoothstep(0.010, 0.034, distance.abs()))
}

/// Roughness of a used surface: smudges, and fine scratches in all directions. In [0, 1].
pub fn worn(uv: Vec2) -> f32 {
    let smudge = smoothstep(-0.15, 0.75, fractal(uv, (3, 3), 4, 71));
    let speck = smoothstep(0.35, 0.9, fractal(uv, (24, 24), 2, 78));
    0.42 + 0.33 * smudge + 0.12 * speck + 0.16 * scratches(uv)
}

fn scratches(uv: Vec2) -> f32 {
    // Stretched noise in four directions; whole-number shears keep it tiling.
    let sheared = [vec2(uv.x, uv.y), vec2(uv.y, uv.x), vec2(uv.x + uv.y, uv.y - uv.x), vec2(uv.x + 2.0 * uv.y, uv.y)];
    let lines = sheared.iter().enumerate().map(|(k, p)| {
        let line = gradient(*p - p.floor(), (3, 220), 81 + k as u32);
        smoothstep(0.62, 0.85, line)
    });
    lines.fold(0.0, f32::max)
}

/// Roughness of a fired glaze: mostly even, pooled and breathed upon. In [0, 1].
pub fn glaze(uv: Vec2) -> f32 {
    let pooled = smoothstep(-0.4, 0.6, fractal(uv, (4, 3), 4, 91));
    let breath = smoothstep(0.15, 0.7, fractal(uv, (9, 7), 3, 97));
    lerp(0.72, 0.92, pooled) + 0.08 * breath
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_tile() {
        let patterns: [fn(Vec2) -> f32; 7] =
            [|p| walnut(p).x, |p| oak(p).y, |p| linen(p).y, |p| upholstery(p).y, |p| hammered(p, 12), engraved, worn];
        for (k, pattern) in patterns.iter().enumerate() {
            for i in 0..400 {
                // Off the threads' borders, where a pattern may jump.
                let p = vec2(((7 * i) % 40) as f32 + 0.37, i as f32 / 10.0 + 0.029) / 40.0;
                let step = pattern(p) - pattern(p + 1.0);
                assert!(step.abs() < 2e-3, "pattern {k} at {p}: {step}");
            }
        }
    }
}
