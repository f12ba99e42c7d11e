// The post pass: the mean of all samples as displayed. Twin of render/src/cpu/display.rs.

struct Display {
    // Scale of radiance.
    exposure: f32,
    // Count at the upper end of the false colors.
    count_top: f32,
    tone_map: u32,
    view_mode: u32,
    // 1: uncovered pixels are transparent.
    transparent: u32,
    // 1: a ground transmits light.
    lets_light_through: u32,
    // Samples per pixel at rest.
    samples: u32,
    // How much darker the corners are, 0 to 1.
    vignette: f32,
}

@group(0) @binding(0) var<uniform> display: Display;
// Every 17th color of magma, sRGB encoded.
@group(0) @binding(1) var<uniform> magma_stops: array<vec4<f32>, 16>;
// Sums of the parts of the light; missing parts are a texel of zeros.
@group(0) @binding(2) var environment_value: texture_2d<f32>;
@group(0) @binding(3) var environment_work: texture_2d<u32>;
@group(0) @binding(4) var bounce_value: texture_2d<f32>;
@group(0) @binding(5) var bounce_work: texture_2d<u32>;
@group(0) @binding(6) var mirrors_value: texture_2d<f32>;
@group(0) @binding(7) var mirrors_work: texture_2d<u32>;
@group(0) @binding(8) var direct_value: texture_2d<f32>;
@group(0) @binding(9) var direct_work: texture_2d<u32>;
@group(0) @binding(10) var added_value: texture_2d<f32>;
@group(0) @binding(11) var added_work: texture_2d<u32>;

const MODE_SHADED: u32 = 0u;
const MODE_ALBEDO: u32 = 2u;
const MODE_VISIBILITY_CUT: u32 = 4u;
const MODE_BRDF_EVALUATIONS: u32 = 6u;
const MODE_BASIS_LEVEL: u32 = 7u;
const MODE_GLOSS: u32 = 10u;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    let value = textureLoad(environment_value, pixel, 0);
    let work = textureLoad(environment_work, pixel, 0);
    var total = mean(value, work);
    total += mean(textureLoad(bounce_value, pixel, 0), textureLoad(bounce_work, pixel, 0));
    total += smoothed(pixel);
    total += mean(textureLoad(direct_value, pixel, 0), textureLoad(direct_work, pixel, 0));
    total += mean(textureLoad(added_value, pixel, 0), textureLoad(added_work, pixel, 0));
    let light = vignette(position.xy);
    if display.transparent == 0u {
        return vec4(with_lines(light * total.xyz, total.w), 1.0);
    }
    let through = select(0.0, total.w, display.lets_light_through != 0u);
    let coverage = max(f32(covered_count(work)) / f32(max(sample_count(work), 1u)) - through, 0.0);
    if coverage == 0.0 {
        return vec4(0.0);
    }
    // The background must not show where the picture has no coverage, so the mean is over covered samples.
    let lines = select(total.w, 0.0, display.lets_light_through != 0u);
    return vec4(with_lines(light * (total.xyz - through) / coverage, lines / coverage), coverage);
}

fn shows_light() -> bool {
    return display.view_mode == MODE_SHADED || display.view_mode == MODE_BASIS_LEVEL || display.view_mode == MODE_GLOSS;
}

// Share of the light at a place of the picture, in pixels. Twin of `vignetted` in render/src/post.rs.
fn vignette(place: vec2<f32>) -> f32 {
    if display.vignette == 0.0 || !shows_light() {
        return 1.0;
    }
    let half = 0.5 * vec2<f32>(textureDimensions(environment_value));
    let off = place - half;
    let cosine_sq = 1.0 / (1.0 + display.vignette * dot(off, off) / dot(half, half));
    return cosine_sq * cosine_sq;
}

const LEAST_WIDTH: f32 = 0.01;
const REACH: i32 = 2;
const MOST_RATIO: f32 = 1.1;

// Mean of what mirrors show in a pixel, smoothed the more the fewer samples it has. Twin of render/src/cpu/picture/smoothed.rs.
fn smoothed(pixel: vec2<u32>) -> vec4<f32> {
    let samples = sample_count(textureLoad(mirrors_work, pixel, 0));
    let own = mirrors_at(pixel);
    let width = mirror_width(pixel);
    if samples >= display.samples || !(width > LEAST_WIDTH) {
        return own;
    }
    let last = vec2<i32>(textureDimensions(mirrors_value)) - 1;
    let low = max(vec2<i32>(pixel) - REACH, vec2(0));
    let high = min(vec2<i32>(pixel) + REACH, last);
    var sum = vec4(0.0);
    var count = 0.0;
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            let other = mirror_width(vec2<u32>(vec2(x, y)));
            if max(other, width) < MOST_RATIO * min(other, width) {
                sum += mirrors_at(vec2<u32>(vec2(x, y)));
                count += 1.0;
            }
        }
    }
    return mix(own, sum / count, 1.0 / sqrt(f32(max(samples, 1u))));
}

fn mirrors_at(pixel: vec2<u32>) -> vec4<f32> {
    return mean(textureLoad(mirrors_value, pixel, 0), textureLoad(mirrors_work, pixel, 0));
}

// Width of the widest sharp lobe.
fn mirror_width(pixel: vec2<u32>) -> f32 {
    let work = textureLoad(mirrors_work, pixel, 0);
    return f32(work.x) / (WIDTH_SCALE * f32(max(sample_count(work), 1u)));
}

fn mean(value: vec4<f32>, work: vec4<u32>) -> vec4<f32> {
    return value / f32(max(sample_count(work), 1u));
}

// A displayed value below lines with this coverage.
fn with_lines(value: vec3<f32>, lines: f32) -> vec3<f32> {
    return mix(display_value(value), LINE_COLOR, LINE_OPACITY * lines);
}

fn display_value(value: vec3<f32>) -> vec3<f32> {
    // NaN must be visible. Compilers may assume that every value equals itself, so this tests its bits.
    if any((bitcast<vec3<u32>>(value) & vec3(0x7fffffffu)) > vec3(0x7f800000u)) {
        return vec3(1.0, 0.0, 1.0);
    }
    if shows_light() {
        return srgb_from_linear(tone_map(display.tone_map, value * display.exposure));
    }
    if display.view_mode == MODE_ALBEDO {
        return srgb_from_linear(value);
    }
    if display.view_mode >= MODE_VISIBILITY_CUT && display.view_mode <= MODE_BRDF_EVALUATIONS {
        return magma(value.x / display.count_top);
    }
    return saturate(value);
}

const LINE_OPACITY: f32 = 0.7;
const LINE_COLOR: vec3<f32> = vec3<f32>(0.10, 0.75, 0.95);

fn magma(x: f32) -> vec3<f32> {
    let position = saturate(x) * 15.0;
    let below = min(u32(position), 14u);
    return mix(magma_stops[below].xyz, magma_stops[below + 1u].xyz, position - f32(below));
}
