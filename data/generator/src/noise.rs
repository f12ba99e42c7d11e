//! Seeded noise that tiles: equal on every machine and in every run.

use glam::{Vec2, vec2};

/// A well-mixed 32-bit hash (the finalizer of MurmurHash3 over a simple combination).
pub fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut h =
        (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85EB_CA6B);
    h ^= h >> 13;
    h = h.wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// A number in [0, 1) from lattice coordinates.
pub fn unit(x: i32, y: i32, seed: u32) -> f32 {
    (hash(x, y, seed) >> 8) as f32 / (1 << 24) as f32
}

/// Gradient noise in about [-1, 1] with `period` cells across the unit square, tiling on it.
pub fn gradient(uv: Vec2, period: (i32, i32), seed: u32) -> f32 {
    let at = uv * vec2(period.0 as f32, period.1 as f32);
    let cell = at.floor();
    let within = at - cell;
    let slope = |dx: i32, dy: i32| {
        let x = (cell.x as i32 + dx).rem_euclid(period.0);
        let y = (cell.y as i32 + dy).rem_euclid(period.1);
        let direction = Vec2::from_angle(unit(x, y, seed) * std::f32::consts::TAU);
        direction.dot(within - vec2(dx as f32, dy as f32))
    };
    let ease = within * within * within * (within * (within * 6.0 - 15.0) + 10.0);
    let low = lerp(slope(0, 0), slope(1, 0), ease.x);
    let high = lerp(slope(0, 1), slope(1, 1), ease.x);
    1.5 * lerp(low, high, ease.y)
}

/// Several octaves of gradient noise, each twice as fine and half as strong; about [-1, 1].
pub fn fractal(uv: Vec2, period: (i32, i32), octaves: u32, seed: u32) -> f32 {
    let mut sum = 0.0;
    for octave in 0..octaves {
        let scale = 1 << octave;
        sum += gradient(uv, (period.0 * scale, period.1 * scale), seed + octave) / scale as f32;
    }
    sum
}

/// Distances, in cells, to the nearest and second nearest of one jittered point per cell; tiles.
pub fn cells(uv: Vec2, period: i32, jitter: f32, seed: u32) -> (f32, f32) {
    let at = uv * period as f32;
    let cell = at.floor();
    let (mut first, mut second) = (f32::INFINITY, f32::INFINITY);
    for dy in -2..=2 {
        for dx in -2..=2 {
            let (x, y) = (cell.x as i32 + dx, cell.y as i32 + dy);
            let key = (x.rem_euclid(period), y.rem_euclid(period));
            let moved = vec2(unit(key.0, key.1, seed), unit(key.0, key.1, seed + 1)) - 0.5;
            let distance = at.distance(vec2(x as f32 + 0.5, y as f32 + 0.5) + moved * jitter);
            if distance < first {
                second = first;
                first = distance;
            } else {
                second = second.min(distance);
            }
        }
    }
    (first, second)
}

/// Linear interpolation.
pub fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Smooth step from 0 at `from` to 1 at `to`.
pub fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_tiles() {
        for k in 0..50 {
            let v = k as f32 / 50.0;
            let pairs = [(vec2(0.0, v), vec2(1.0, v)), (vec2(v, 0.0), vec2(v, 1.0))];
            for (a, b) in pairs {
                assert!((fractal(a, (3, 5), 4, 7) - fractal(b, (3, 5), 4, 7)).abs() < 1e-4);
                assert!((cells(a, 6, 0.8, 3).0 - cells(b, 6, 0.8, 3).0).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn the_hash_fills_the_unit_interval() {
        let mean = (0..10_000).map(|k| unit(k, 3, 9)).sum::<f32>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.02, "{mean}");
    }
}
