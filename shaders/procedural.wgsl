// Procedural patterns, filtered by a sample's footprint. Twin of core/src/texture/procedural.rs.

const PATTERN_CHECKER: u32 = 0u;
const PATTERN_NOISE: u32 = 1u;

const NOISE_CELLS: u32 = 4u;
const SHARPEST: f32 = 0.01;
const SLOPE_SQ: f32 = 0.186;

fn triangle_wave(x: vec2<f32>) -> vec2<f32> {
    return abs(x - floor(x) - 0.5);
}

// Mean over a width of the wave that is -1 in the first half of each unit and 1 in the second.
fn square_waves(x: vec2<f32>, width: vec2<f32>) -> vec2<f32> {
    return (triangle_wave(x + 0.5 * width) - triangle_wave(x - 0.5 * width)) / width;
}

fn saw_sum(x: f32) -> f32 {
    let f = x - floor(x);
    return 0.5 * (floor(x) + f * f);
}

// Evenly distributed in [0, 1).
fn noise_corner(x: u32, y: u32, octave: u32) -> f32 {
    var h = (x * 0x9e3779b1u) ^ (y * 0x85ebca77u) ^ (octave * 0xc2b2ae3du);
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    return f32((h ^ (h >> 16u)) >> 8u) / 16777216.0;
}

fn value_noise(uv: vec2<f32>, cells: u32, octave: u32) -> f32 {
    let p = (uv - floor(uv)) * f32(cells);
    let low = vec2<u32>(floor(p)) % vec2(cells);
    let high = (low + 1u) % vec2(cells);
    let f = p - floor(p);
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let a = noise_corner(low.x, low.y, octave);
    let b = noise_corner(high.x, low.y, octave);
    let c = noise_corner(low.x, high.y, octave);
    let d = noise_corner(high.x, high.y, octave);
    let top = a + (b - a) * s.x;
    let bottom = c + (d - c) * s.x;
    return top + (bottom - top) * s.y;
}

// Share of the higher value within a footprint, and the mean square of unresolved slopes.
fn procedural_filtered(slot: TextureSlot, at: UvFootprint) -> vec2<f32> {
    let uv = at.uv - floor(at.uv);
    if slot.pattern != PATTERN_NOISE {
        let width = max(abs(at.right) + abs(at.below), vec2(SHARPEST));
        let waves = square_waves(uv, width);
        let saw = (saw_sum(uv.x + 0.5 * width.x) - saw_sum(uv.x - 0.5 * width.x)) / width.x;
        return vec2(select(saw, 0.5 - 0.5 * waves.x * waves.y, slot.pattern == PATTERN_CHECKER), 0.0);
    }
    let width = sqrt(0.5 * (dot(at.right, at.right) + dot(at.below, at.below)));
    var sum = 0.0;
    var fine = 0.0;
    var all = 0.0;
    var weight = 1.0;
    for (var octave = 0u; octave < slot.octaves; octave++) {
        let cells = NOISE_CELLS << octave;
        let size = f32(cells);
        let seen = clamp(1.1 - 0.36 * width * size, 0.0, 1.0);
        if seen > 0.0 {
            sum += weight * seen * (value_noise(uv, cells, octave) - 0.5);
        }
        fine += weight * weight * (1.0 - seen * seen) * (SLOPE_SQ * size * size);
        all += weight;
        weight *= 0.5;
    }
    return vec2(0.5 + sum / all, fine / (all * all));
}

fn procedural_value(slot: TextureSlot, at: UvFootprint) -> vec4<f32> {
    return vec4(slot.low + (slot.high - slot.low) * procedural_filtered(slot, at).x, 1.0);
}

// A footprint after the slot's transform.
fn through_slot(slot: TextureSlot, at: UvFootprint) -> UvFootprint {
    let turn = mat2x2<f32>(linear_column(slot, 0u), linear_column(slot, 1u));
    return UvFootprint(transform_uv(slot, at.uv), turn * at.right, turn * at.below);
}
