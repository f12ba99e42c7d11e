// A measured BRDF, tinted. Twin of core/src/brdf/merl.rs and core/src/brdf/measured.rs.

// The tables in use, see render/src/gpu/measured.rs: a header, the levels' headers, and the levels' entries in 16-bit floats.
@group(1) @binding(5) var<storage, read> measured: array<u32>;

const MERL_PI: f32 = 3.14159265;
const MERL_HALF_PI: f32 = 1.57079633;
const MERL_HEAD_WORDS: u32 = 8u;

struct Merl {
    // First word of its table.
    table: u32,
    tint: vec3<f32>,
    estimate: vec4<f32>,
}

fn merl_of(p: MerlParameters, table: u32, estimate: vec4<f32>) -> Merl {
    return Merl(table, p.tint, estimate);
}

fn merl_number(word: u32) -> f32 {
    return bitcast<f32>(measured[word]);
}

// Position of a pair of directions in a table; see `Angles`.
struct MeasuredAngles {
    half: f32,
    difference: f32,
    azimuth: f32,
    spread: f32,
}

fn merl_angle(y: f32, x: f32) -> f32 {
    let is_low = y < abs(x);
    let t = select(abs(x), y, is_low) / max(select(y, abs(x), is_low), 1e-20);
    let s = t * t;
    let series = 0.99997726
        + s * (-0.33262347 + s * (0.19354346 + s * (-0.11643287 + s * (0.05265332 - s * 0.0117212))));
    let acute = select(MERL_HALF_PI - t * series, t * series, is_low);
    return select(acute, MERL_PI - acute, x < 0.0);
}

fn merl_azimuth(wi: vec3<f32>, h: vec3<f32>) -> f32 {
    let sin_h = length(h.xy);
    var turn = vec2(1.0, 0.0);
    if sin_h > 1e-6 {
        turn = h.xy / sin_h;
    }
    let x = h.z * dot(turn, wi.xy) - sin_h * wi.z;
    let y = turn.x * wi.y - turn.y * wi.x;
    return FRAC_1_PI * select(merl_angle(y, x), merl_angle(-y, -x), y < 0.0);
}

fn measured_angles(light: Light, wo: vec3<f32>, width_sq: f32) -> MeasuredAngles {
    let half = half_vector(light, wo);
    let h = half.h;
    let cos_d = min(half.wi_dot_h, 1.0);
    let m = half.spread + vec3(width_sq, 0.0, width_sq);
    let area = sqrt(max(determinant_of(m), 1e-14));
    let sin_h = min(sqrt(max(adjugate_quadratic(m, h.xy) / area, 0.0)), 1.0);
    let angle_h = merl_angle(sin_h, sqrt(max(1.0 - sin_h * sin_h, 0.0)));
    let angle_d = merl_angle(sqrt(max(1.0 - cos_d * cos_d, 0.0)), cos_d);
    return MeasuredAngles(sqrt(angle_h / MERL_HALF_PI), angle_d / MERL_HALF_PI, merl_azimuth(light.wi, h), area - width_sq);
}

// A nonnegative 16-bit float, 0 or normal: not all adapters have `unpack2x16float`.
fn merl_half(bits: u32) -> f32 {
    // Exponents of 32 bits begin 112 lower.
    return bitcast<f32>(bits << 13u) * bitcast<f32>(239u << 23u);
}

fn merl_entry(first: u32, index: u32) -> vec3<f32> {
    let word = first + 2u * index;
    let rg = measured[word];
    return vec3(merl_half(rg & 0xffffu), merl_half(rg >> 16u), merl_half(measured[word + 1u]));
}

// An entry along one axis and the weight of the next.
fn merl_inner(x: f32, n: u32) -> vec2<f32> {
    let place = clamp(x * f32(n) - 0.5, 0.0, f32(n - 1u));
    let low = min(floor(place), f32(n - 2u));
    return vec2(low, place - low);
}

fn merl_level(level: u32, angles: MeasuredAngles) -> vec3<f32> {
    let size = vec3(measured[level], measured[level + 1u], measured[level + 2u]);
    let first = measured[level + 4u];
    let h = merl_inner(angles.half, size.x);
    let d = merl_inner(angles.difference, size.y);
    let p = angles.azimuth * f32(size.z) + (f32(size.z) - 0.5);
    let low = u32(p) % size.z;
    let high = (low + 1u) % size.z;
    var rows: array<vec3<f32>, 4>;
    for (var i = 0u; i < 4u; i++) {
        let row = ((u32(h.x) + i / 2u) * size.y + u32(d.x) + i % 2u) * size.z;
        rows[i] = mix(merl_entry(first, row + low), merl_entry(first, row + high), fract(p));
    }
    return mix(mix(rows[0], rows[1], d.y), mix(rows[2], rows[3], d.y), h.y);
}

fn merl_value(table: u32, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let width_sq = merl_number(table);
    let angles = measured_angles(light, wo, width_sq);
    let levels = table + MERL_HEAD_WORDS;
    let last = measured[table + 1u] - 1u;
    var lower = 0u;
    for (var i = 1u; i <= last; i++) {
        if merl_number(levels + i * MERL_HEAD_WORDS + 3u) <= angles.spread {
            lower = i;
        }
    }
    let level = levels + lower * MERL_HEAD_WORDS;
    let value = merl_level(level, angles);
    if lower == last {
        return value;
    }
    // The height of a lobe is proportional to the inverse of its squared width.
    let low = 1.0 / (width_sq + merl_number(level + 3u));
    let high = 1.0 / (width_sq + merl_number(level + MERL_HEAD_WORDS + 3u));
    let part = clamp((1.0 / (width_sq + angles.spread) - low) / (high - low), 0.0, 1.0);
    if part > 0.0 {
        return mix(value, merl_level(level + MERL_HEAD_WORDS, angles), part);
    }
    return value;
}

fn merl_reflect(brdf: Merl, light: Light, wo: vec3<f32>) -> vec3<f32> {
    if !(light.cosine > 0.0) {
        return vec3(0.0);
    }
    if brdf.table == NO_TABLE {
        return MISSING_ALBEDO * (FRAC_1_PI * light.cosine);
    }
    // A light whose center is below the horizon may be partly above it.
    let wi = vec3(light.wi.xy, max(light.wi.z, 0.0));
    let size = length(wi);
    var above = light;
    above.wi = select(vec3(0.0, 0.0, 1.0), wi / size, size > 0.0);
    return merl_value(brdf.table, above, wo) * brdf.tint * light.cosine;
}

fn merl_lobes(brdf: Merl) -> mat3x2<f32> {
    return mat3x2(vec2(brdf.estimate.w), NO_LOBE, NO_LOBE);
}

fn merl_albedo(brdf: Merl) -> vec3<f32> {
    return brdf.estimate.xyz * select(brdf.tint, vec3(1.0), brdf.table == NO_TABLE);
}
