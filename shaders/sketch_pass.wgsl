// The joint bilateral filter between lattice pixels, on radiance over albedo. Twin of the filter in
// render/src/cpu/sketch/filter.rs, except that it shades no pixels. Texel (i, j) of the lattice is pixel (i, j) * stride.

// A pass fills one part of the light in pixels without its first sample.

@group(2) @binding(0) var lattice_value: texture_2d<f32>;
@group(2) @binding(1) var lattice_work: texture_2d<u32>;
// Prediction from the last picture, with alpha 1 where it has one; a texel of zeros without a last picture.
@group(2) @binding(2) var predicted: texture_2d<f32>;
@group(3) @binding(5) var environment_map: texture_2d<f32>;

// Weight of another material if nothing fits.
const OTHER: f32 = 1e-3;

fn written_at(texel: vec2<u32>) -> Sums {
    let begun = begin(texel);
    if !begun.has_surface {
        return with_background(begun, ray(begun.pixel).direction);
    }
    let here = guide(begun.g, begun.pixel);
    let lines = lines_at(begun.pixel, triangles[begun.g.x - 1u].vertices);
    return with_sample(begun, vec4(filtered(begun.pixel, here) * here.divisor, lines), NO_WORK);
}

fn filtered(pixel: vec2<u32>, here: Guide) -> vec3<f32> {
    let told = textureLoad(predicted, pixel, 0);
    for (var cells = 1; cells <= 2; cells++) {
        let sums = interpolated(pixel, here, cells, told.w > 0.0);
        if sums.now.w >= LEAST_SHARE * f32(cells * cells) {
            return max(sums.now.xyz / sums.now.w + detail(told.xyz, sums), vec3(0.0));
        }
    }
    if told.w > 0.0 {
        return told.xyz;
    }
    let sum = guess(pixel, here);
    if !(sum.w > 0.0) {
        return vec3(0.0);
    }
    return sum.xyz / sum.w;
}

// Sums over the lattice around a pixel, with the sum of the weights.
struct LatticeSums {
    now: vec4<f32>,
    // Sums over the lattice in the last picture, where known.
    before: vec4<f32>,
    // Sums of the smaller and of the larger luminance of each pair before and now.
    least: f32,
    most: f32,
}

// The tent covers `cells` cells on each side.
fn interpolated(pixel: vec2<u32>, here: Guide, cells: i32, has_past: bool) -> LatticeSums {
    var sums = LatticeSums(vec4(0.0), vec4(0.0), 0.0, 0.0);
    for (var i = 0; i < 4 * cells * cells; i++) {
        let point = lattice_point(pixel, cells, i);
        if !(point.weight > 0.0) {
            continue;
        }
        let there = guide(textureLoad(geometry, point.pixel, 0), point.pixel);
        let weight = point.weight * fit(here, there);
        let now = lattice_radiance(point.texel) / there.divisor;
        sums.now += vec4(now, 1.0) * weight;
        let before = textureLoad(predicted, point.pixel, 0);
        if has_past && before.w > 0.0 {
            let luminances = vec2(luminance(before.xyz), luminance(now));
            sums.before += vec4(before.xyz, 1.0) * weight;
            sums.least += weight * min(luminances.x, luminances.y);
            sums.most += weight * max(luminances.x, luminances.y);
        }
    }
    return sums;
}

// Difference of the last picture from its own filtered value at a pixel, as far as the two pictures agree. Twin of `Detail` in
// render/src/cpu/sketch/history.rs.
fn detail(told: vec3<f32>, sums: LatticeSums) -> vec3<f32> {
    if !(sums.most > 0.0) {
        return vec3(0.0);
    }
    return sums.least / sums.most * (told - sums.before.xyz / sums.before.w);
}

// Sum over the nearest surfaces and of the weights, with a strong preference for the same material.
fn guess(pixel: vec2<u32>, here: Guide) -> vec4<f32> {
    var sum = vec4(0.0);
    for (var i = 0; i < 16; i++) {
        let point = lattice_point(pixel, 2, i);
        if point.weight > 0.0 {
            let there = guide(textureLoad(geometry, point.pixel, 0), point.pixel);
            let weight = point.weight * select(OTHER, 1.0, there.material == here.material);
            sum += vec4(lattice_radiance(point.texel) / there.divisor, 1.0) * weight;
        }
    }
    return sum;
}

// A lattice point near a pixel, with its weight in a tent; zero without a surface to shade.
struct LatticePoint {
    texel: vec2<i32>,
    pixel: vec2<u32>,
    weight: f32,
}

fn lattice_point(pixel: vec2<u32>, cells: i32, i: i32) -> LatticePoint {
    let stride = i32(frame.stride.x);
    let texel = vec2<i32>(pixel) / stride - (cells - 1) + vec2(i % (2 * cells), i / (2 * cells));
    let other = texel * stride;
    if any(texel < vec2(0)) || any(other >= vec2<i32>(frame.size)) {
        return LatticePoint(texel, pixel, 0.0);
    }
    let away = abs(vec2<f32>(other - vec2<i32>(pixel))) / f32(cells * stride);
    let tent = max(1.0 - away, vec2(0.0));
    let shows = is_surface(textureLoad(geometry, other, 0));
    return LatticePoint(texel, vec2<u32>(other), select(0.0, tent.x * tent.y, shows));
}

fn lattice_radiance(texel: vec2<i32>) -> vec3<f32> {
    let samples = f32(max(sample_count(textureLoad(lattice_work, texel, 0)), 1u));
    return textureLoad(lattice_value, texel, 0).xyz / samples;
}

// Twin of `Guide::fit`.
fn fit(here: Guide, there: Guide) -> f32 {
    let reach = f32(frame.stride.x) * pixel_span(1.0) * distance(here.position, frame.eye);
    let a = luminance(here.albedo);
    let b = luminance(there.albedo);
    return fit_surface(here, there.material, there.position, there.normal, reach) * (min(a, b) / max(a, b));
}
