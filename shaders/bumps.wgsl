// The normal after normal and bump map, and the spread of the normals within a sample's footprint. Twin of
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
// Words per texel in a level of slopes: mean; variances; their product.
const SLOPE_WORDS: u32 = 3u;

fn slope_of(normal: vec3<f32>) -> vec2<f32> {
    return normal.xy / max(max(normal.z, LEAST_Z * length(normal)), 1e-6);
}

fn pair_of(word: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(vec2(word << 16u, word & 0xffff0000u));
}

fn slope_texel(level: Level, x: u32, y: u32) -> SlopeMoments {
    let first = level.first + SLOPE_WORDS * (y * level.size.x + x);
    let mean = pair_of(pool_word(first));
    let variances = pair_of(pool_word(first + 1u));
    let product = pair_of(pool_word(first + 2u)).x;
    let own = moments_of(mean);
    return SlopeMoments(mean, own.second + vec3(variances.x, product, variances.y));
}

fn slope_level(slot: TextureSlot, level: u32, uv: vec2<f32>) -> SlopeMoments {
    let there = level_of(slot, level, SLOPE_WORDS);
    let quad = quad_around(there.size, uv, slot.lookup);
    var sum = SlopeMoments(vec2(0.0), vec3(0.0));
    for (var i = 0u; i < 4u; i++) {
        let is_high = vec2((i & 1u) != 0u, i > 1u);
        let at = select(quad.low, quad.high, is_high);
        let weights = select(1.0 - quad.blend, quad.blend, is_high);
        sum = moments_sum(sum, weights.x * weights.y, slope_texel(there, at.x, at.y));
    }
    return sum;
}

// Slopes of a texture at a point, in surface units: of normals, or of heights if `is_height`.
fn finest_slope(slot: TextureSlot, uv: vec2<f32>, is_height: bool) -> vec2<f32> {
    if !is_height {
        return slope_of(2.0 * sample_texture(slot, uv).xyz - 1.0);
    }
    // Changes of height in meters per unit of u and v, by central differences over one texel.
    let texels = vec2(f32(slot.width), f32(slot.height)) * slot.scale;
    let steps = 1.0 / max(abs(texels), vec2(1e-6));
    var change = vec2(0.0);
    for (var i = 0u; i < 4u; i++) {
        let axis = i >> 1u;
        let sign = select(1.0, -1.0, (i & 1u) != 0u);
        let along = sign * steps[axis] * linear_column(slot, axis);
        let height = sample_texture(slot, uv + along)[channel_of(slot)];
        change += select(vec2(0.0, sign * height), vec2(sign * height, 0.0), axis == 0u);
    }
    return slot.strength * change / (2.0 * steps);
}

// Slopes of a level; those of heights fall where a mirrored picture rises.
fn slope_below(slot: TextureSlot, level: u32, uv: vec2<f32>, is_height: bool) -> SlopeMoments {
    let moments = slope_level(slot, level, uv);
    if !is_height {
        return moments;
    }
    let rising = vec2(folded_slope(uv.x, wrap_of(slot, 0u)), folded_slope(uv.y, wrap_of(slot, 1u)));
    return moments_mapped(moments, vec2(rising.x, 0.0), vec2(0.0, rising.y));
}

// Slopes within taps. The columns of a matrix convert levels to surface units.
fn slopes_within(
    slot: TextureSlot,
    taps: Taps,
    column_x: vec2<f32>,
    column_y: vec2<f32>,
    is_height: bool,
) -> SlopeMoments {
    let level = min(taps.level, f32(last_level(slot)));
    let blend = fract(level);
    let share = 1.0 / f32(taps.count);
    var finest = SlopeMoments(vec2(0.0), vec3(0.0));
    var lower = finest;
    // For each tap the finer and the coarser level.
    for (var i = 0u; i < 2u * taps.count; i++) {
        let uv = taps.first + taps.step * f32(i >> 1u);
        let weight = share * select(1.0 - blend, blend, (i & 1u) != 0u);
        let at = u32(level) + (i & 1u);
        if !(weight > 0.0) {
            continue;
        }
        if at == 0u {
            finest = moments_sum(finest, weight, moments_of(finest_slope(slot, uv, is_height)));
        } else {
            lower = moments_sum(lower, weight, slope_below(slot, at, uv, is_height));
        }
    }
    return moments_sum(finest, 1.0, moments_mapped(lower, column_x, column_y));
}

// Slopes that tilt a normal: their covariance, and the normal's change with each.
struct Moving {
    covariance: vec3<f32>,
    x: vec3<f32>,
    y: vec3<f32>,
}

// The mean normal and the slopes that tilt it: normal map and bump map.
struct Bumped {
    normal: vec3<f32>,
    by_normals: Moving,
    by_heights: Moving,
}

fn bumped_normal(material: u32, corners: vec3<u32>, b: vec3<f32>, smoothed: mat3x3<f32>) -> Bumped {
    let still = Moving(vec3(0.0), vec3(0.0), vec3(0.0));
    var bumped = Bumped(smoothed[2], still, still);
    let normal_map = materials[material].normal_map;
    if normal_map.kind != 0u {
        let axes = normal_axes(normal_map);
        let uv = footprint_at(corners, b, uv_set_of(normal_map));
        let taps = taps_of(normal_map, uv);
        if is_point(taps) || normal_map.kind == KIND_PROCEDURAL {
            let n = 2.0 * sample_slot(normal_map, uv).xyz - 1.0;
            bumped.normal = normalize_or(smoothed * vec3(axes * n.xy, n.z), bumped.normal);
        } else {
            let within = slopes_within(normal_map, taps, vec2(1.0, 0.0), vec2(0.0, 1.0), false);
            let moments = moments_mapped(within, axes[0], axes[1]);
            let shorter = 1.0 / sqrt(1.0 + dot(moments.mean, moments.mean));
            bumped.normal = (smoothed * vec3(moments.mean, 1.0)) * shorter;
            bumped.by_normals = Moving(covariance_of(moments), smoothed[0] * shorter, smoothed[1] * shorter);
        }
    }
    let bump_map = materials[material].bump_map;
    let slopes = surface_slopes(corners, corner_uvs(corners, uv_set_of(bump_map)));
    if bump_map.kind != 0u && slopes.is_regular {
        let moments = height_moments(bump_map, footprint_at(corners, b, uv_set_of(bump_map)));
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

// Changes of height in meters per unit of u and v.
fn height_moments(slot: TextureSlot, uv: UvFootprint) -> SlopeMoments {
    if slot.kind == KIND_PROCEDURAL {
        return pattern_moments(slot, through_slot(slot, uv));
    }
    let taps = taps_of(slot, uv);
    let x = slot.strength * f32(slot.width) * vec2(linear_column(slot, 0u).x, linear_column(slot, 1u).x);
    let y = slot.strength * f32(slot.height) * vec2(linear_column(slot, 0u).y, linear_column(slot, 1u).y);
    return slopes_within(slot, taps, x, y, true);
}

// Half the distance between two pattern lookups for a slope.
const PATTERN_STEP: f32 = 1e-3;

// Slopes of a pattern.
fn pattern_moments(slot: TextureSlot, there: UvFootprint) -> SlopeMoments {
    let turn = mat2x2<f32>(linear_column(slot, 0u), linear_column(slot, 1u));
    let steps = PATTERN_STEP / max(vec2(length(turn[0]), length(turn[1])), vec2(1e-6));
    var change = vec2(0.0);
    for (var i = 0u; i < 4u; i++) {
        let is_x = i < 2u;
        let sign = select(1.0, -1.0, (i & 1u) != 0u);
        let along = sign * select(steps.y * turn[1], steps.x * turn[0], is_x);
        let height = procedural_value(slot, UvFootprint(there.uv + along, there.right, there.below))[channel_of(slot)];
        change += select(vec2(0.0, sign * height), vec2(sign * height, 0.0), is_x);
    }
    var moments = moments_of(slot.strength * change / (2.0 * steps));
    var range = 0.0;
    if channel_of(slot) < 3u {
        range = slot.high[channel_of(slot)] - slot.low[channel_of(slot)];
    }
    let fine = slot.strength * slot.strength * range * range * procedural_filtered(slot, there).y;
    let rows = transpose(turn);
    moments.second += covariance_mapped(vec3(fine, 0.0, fine), rows[0], rows[1]);
    return moments;
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
