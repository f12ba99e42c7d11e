// The normal after normal and bump map, and how far the normals within the footprint of a sample spread around it. Twin of
// render/src/shade/bumps.rs and core/src/texture/slopes.rs.

// First and second moments of slopes; the second are xx, xy, yy.
struct SlopeMoments {
    mean: vec2<f32>,
    second: vec3<f32>,
}

fn moments_of(slope: vec2<f32>) -> SlopeMoments {
    return SlopeMoments(slope, vec3(slope.x * slope.x, slope.x * slope.y, slope.y * slope.y));
}

fn moments_sum(a: SlopeMoments, weight: f32, b: SlopeMoments) -> SlopeMoments {
    return SlopeMoments(a.mean + weight * b.mean, a.second + weight * b.second);
}

// B M B^T for M given as xx, xy, yy and the columns of B.
fn covariance_mapped(m: vec3<f32>, column_x: vec2<f32>, column_y: vec2<f32>) -> vec3<f32> {
    let x = vec2(column_x.x, column_y.x);
    let y = vec2(column_x.y, column_y.y);
    return vec3(quadratic_of(m, x, x), quadratic_of(m, x, y), quadratic_of(m, y, y));
}

fn quadratic_of(m: vec3<f32>, a: vec2<f32>, b: vec2<f32>) -> f32 {
    return m.x * a.x * b.x + m.y * (a.x * b.y + a.y * b.x) + m.z * a.y * b.y;
}

fn moments_mapped(moments: SlopeMoments, column_x: vec2<f32>, column_y: vec2<f32>) -> SlopeMoments {
    let mean = column_x * moments.mean.x + column_y * moments.mean.y;
    return SlopeMoments(mean, covariance_mapped(moments.second, column_x, column_y));
}

fn covariance_of(moments: SlopeMoments) -> vec3<f32> {
    let c = moments.second - moments_of(moments.mean).second;
    return vec3(max(c.x, 0.0), c.y, max(c.z, 0.0));
}

const LEAST_Z: f32 = 0.125;
// Words of a texel of a level of slopes: mean; variances; their product.
const SLOPE_WORDS: u32 = 3u;

fn slope_of(normal: vec3<f32>) -> vec2<f32> {
    return normal.xy / max(max(normal.z, LEAST_Z * length(normal)), 1e-6);
}

fn slope_texel(level: Level, x: u32, y: u32) -> SlopeMoments {
    let first = level.first + SLOPE_WORDS * (y * level.size.x + x);
    let mean = unpack2x16float(pool_word(first));
    let variances = unpack2x16float(pool_word(first + 1u));
    let product = unpack2x16float(pool_word(first + 2u)).x;
    let own = moments_of(mean);
    return SlopeMoments(mean, own.second + vec3(variances.x, product, variances.y));
}

fn slope_level(slot: TextureSlot, level: u32, uv: vec2<f32>) -> SlopeMoments {
    let there = level_of(slot, level, SLOPE_WORDS);
    let quad = quad_around(there.size, uv);
    let right = quad.blend.x;
    let below = quad.blend.y;
    var sum = SlopeMoments(vec2(0.0), vec3(0.0));
    sum = moments_sum(sum, (1.0 - right) * (1.0 - below), slope_texel(there, quad.low.x, quad.low.y));
    sum = moments_sum(sum, right * (1.0 - below), slope_texel(there, quad.high.x, quad.low.y));
    sum = moments_sum(sum, (1.0 - right) * below, slope_texel(there, quad.low.x, quad.high.y));
    return moments_sum(sum, right * below, slope_texel(there, quad.high.x, quad.high.y));
}

// Slopes of a texture at a point, in the units of the surface: of normals, or of heights if `is_height`.
fn finest_slope(slot: TextureSlot, uv: vec2<f32>, is_height: bool) -> vec2<f32> {
    if is_height {
        return vec2(height_change(slot, uv, 0u), height_change(slot, uv, 1u));
    }
    return slope_of(2.0 * sample_texture(slot, uv).xyz - 1.0);
}

// Change of height in metres per unit of u or v, by central differences over one texel.
fn height_change(slot: TextureSlot, uv: vec2<f32>, axis: u32) -> f32 {
    let size = vec2(f32(slot.width), f32(slot.height));
    let texels = size[axis] * slot.scale[axis];
    let step = 1.0 / max(abs(texels), 1e-6);
    let along = step * linear_column(slot, axis);
    let ahead = sample_texture(slot, uv + along)[slot.channel];
    let behind = sample_texture(slot, uv - along)[slot.channel];
    return slot.strength * (ahead - behind) / (2.0 * step);
}

// Slopes within taps. Levels are brought to the units of the surface by the columns of a matrix.
fn slopes_within(
    slot: TextureSlot,
    taps: Taps,
    column_x: vec2<f32>,
    column_y: vec2<f32>,
    is_height: bool,
) -> SlopeMoments {
    let level = min(taps.level, f32(last_level(slot)));
    let finer = u32(level);
    let blend = fract(level);
    let share = 1.0 / f32(taps.count);
    var finest = SlopeMoments(vec2(0.0), vec3(0.0));
    var lower = finest;
    for (var i = 0u; i < taps.count; i++) {
        let uv = taps.first + taps.step * f32(i);
        if finer == 0u {
            finest = moments_sum(finest, share * (1.0 - blend), moments_of(finest_slope(slot, uv, is_height)));
        } else {
            lower = moments_sum(lower, share * (1.0 - blend), slope_level(slot, finer, uv));
        }
        if blend > 0.0 {
            lower = moments_sum(lower, share * blend, slope_level(slot, finer + 1u, uv));
        }
    }
    return moments_sum(finest, 1.0, moments_mapped(lower, column_x, column_y));
}

// Slopes that move a normal: their covariance, and how the normal moves with each.
struct Moving {
    covariance: vec3<f32>,
    x: vec3<f32>,
    y: vec3<f32>,
}

// The mean normal, and what moves it: the normal map and the bump map.
struct Bumped {
    normal: vec3<f32>,
    by_normals: Moving,
    by_heights: Moving,
}

const STILL: Moving = Moving(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));

fn bumped_normal(material: u32, corners: vec3<u32>, uv: UvFootprint, smoothed: mat3x3<f32>) -> Bumped {
    var bumped = Bumped(smoothed[2], STILL, STILL);
    let normal_map = materials[material].normal_map;
    if normal_map.kind != 0u {
        let s = normal_map.strength;
        let green = s * materials[material].normal_y;
        let taps = taps_of(normal_map, uv);
        if is_point(taps) {
            let n = (2.0 * sample_texture(normal_map, taps.first).xyz - 1.0) * vec3(s, green, 1.0);
            bumped.normal = normalize_or(smoothed * n, bumped.normal);
        } else {
            let within = slopes_within(normal_map, taps, vec2(1.0, 0.0), vec2(0.0, 1.0), false);
            let moments = moments_mapped(within, vec2(s, 0.0), vec2(0.0, green));
            let shorter = 1.0 / sqrt(1.0 + dot(moments.mean, moments.mean));
            bumped.normal = (smoothed * vec3(moments.mean, 1.0)) * shorter;
            bumped.by_normals = Moving(covariance_of(moments), smoothed[0] * shorter, smoothed[1] * shorter);
        }
    }
    let bump_map = materials[material].bump_map;
    let slopes = surface_slopes(corners);
    if bump_map.kind != 0u && slopes.is_regular {
        let moments = height_moments(bump_map, uv);
        // The gradient along the surface tilts the normal of the raised surface against it (Blinn 1978).
        let tilted = bumped.normal - slopes.per_u * moments.mean.x - slopes.per_v * moments.mean.y;
        let length_sq = dot(tilted, tilted);
        if length_sq > 1e-30 {
            let shorter = 1.0 / sqrt(length_sq);
            bumped.normal = tilted * shorter;
            bumped.by_normals.x *= shorter;
            bumped.by_normals.y *= shorter;
            bumped.by_heights = Moving(covariance_of(moments), slopes.per_u * shorter, slopes.per_v * shorter);
        }
    }
    return bumped;
}

// Changes of height in metres per unit of u and v.
fn height_moments(slot: TextureSlot, uv: UvFootprint) -> SlopeMoments {
    let taps = taps_of(slot, uv);
    if is_point(taps) {
        return moments_of(finest_slope(slot, taps.first, true));
    }
    let x = slot.strength * f32(slot.width) * vec2(linear_column(slot, 0u).x, linear_column(slot, 1u).x);
    let y = slot.strength * f32(slot.height) * vec2(linear_column(slot, 0u).y, linear_column(slot, 1u).y);
    return slopes_within(slot, taps, x, y, true);
}

fn spread_by(moving: Moving, local: mat3x3<f32>) -> vec3<f32> {
    let x = vec2(dot(local[0], moving.x), dot(local[1], moving.x));
    let y = vec2(dot(local[0], moving.y), dot(local[1], moving.y));
    return 2.0 * covariance_mapped(moving.covariance, x, y);
}

// Twice the covariance of the slopes in a frame around the normal: xx, xy, yy.
fn slope_spread(bumped: Bumped, local: mat3x3<f32>) -> vec3<f32> {
    return spread_by(bumped.by_normals, local) + spread_by(bumped.by_heights, local);
}

fn has_bumps(material: u32) -> bool {
    return materials[material].normal_map.kind != 0u || materials[material].bump_map.kind != 0u;
}

// The lesser eigenvalue of a covariance.
fn least_spread(m: vec3<f32>) -> f32 {
    let half = 0.5 * (m.x - m.z);
    return max(0.5 * (m.x + m.z) - sqrt(half * half + m.y * m.y), 0.0);
}
