// The filter between the pixels of a lattice: a joint bilateral one, of radiance over albedo. Twin of the filter in
// render/src/cpu/sketch.rs, but that it shades no pixel itself. Texel (i, j) of the lattice is pixel (i, j) * stride.

// A pass fills one part of the light, where it lacks its first sample.

@group(2) @binding(0) var lattice_value: texture_2d<f32>;
@group(2) @binding(1) var lattice_work: texture_2d<u32>;

// Least albedo that radiance is divided by.
const LEAST_ALBEDO: f32 = 1.0 / 512.0;
// Least share of the filter's weight that must fit.
const LEAST_SHARE: f32 = 1.0 / 16.0;
// Weight of another material where nothing fits.
const OTHER: f32 = 1e-3;
const LUMINANCE: vec3<f32> = vec3<f32>(0.2126, 0.7152, 0.0722);

// Whether it fills the first part of the light, which also has the background and the lines of a wireframe.
override IS_FIRST: bool = true;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Sums {
    let pixel = vec2<u32>(position.xy);
    let sums = previous_sums(pixel);
    if !lacks_sample(sums) {
        return sums;
    }
    let g = textureLoad(geometry, pixel, 0);
    if !is_surface(g) {
        let shows = IS_FIRST && g.x == 0u && frame.view_mode == VIEW_SHADED;
        let shown = select(vec3(0.0), background_radiance(ray_direction(pixel)), shows);
        return with_sample(sums, g, vec4(shown, 0.0), 0u, 0u);
    }
    let here = guide(g, pixel);
    let has_lines = IS_FIRST && frame.wireframe != 0u;
    let wire = select(0.0, wireframe_coverage(pixel, triangles[g.x - 1u].vertices), has_lines);
    return with_sample(sums, g, vec4(filtered(pixel, here) * here.divisor, wire), 0u, 0u);
}

struct Guide {
    material: u32,
    position: vec3<f32>,
    smooth_normal: vec3<f32>,
    normal: vec3<f32>,
    albedo: vec3<f32>,
    // What values are divided by: the albedo, or 1 where they are no radiance.
    divisor: vec3<f32>,
}

fn guide(g: vec4<u32>, pixel: vec2<u32>) -> Guide {
    let point = surface_point(g, pixel, ray_direction(pixel));
    let alpha = lobe_alpha(textureLoad(color_roughness, pixel, 0).w, textureLoad(others, pixel, 0).y);
    let share = max(albedo(point.brdf, alpha), vec3(LEAST_ALBEDO));
    let divisor = select(vec3(1.0), share, frame.view_mode == VIEW_SHADED);
    let material = triangles[g.x - 1u].material & ~TWO_SIDED;
    return Guide(material, point.position, point.smooth_normal, point.world_from_local[2], share, divisor);
}

fn filtered(pixel: vec2<u32>, here: Guide) -> vec3<f32> {
    for (var cells = 1; cells <= 2; cells++) {
        let sum = weighted_sum(pixel, here, cells, true);
        if sum.w >= LEAST_SHARE * f32(cells * cells) {
            return sum.xyz / sum.w;
        }
    }
    let sum = weighted_sum(pixel, here, 2, false);
    if !(sum.w > 0.0) {
        return vec3(0.0);
    }
    return sum.xyz / sum.w;
}

// Sum over the lattice around a pixel, and of the weights; the tent is `cells` wide on each side.
fn weighted_sum(pixel: vec2<u32>, here: Guide, cells: i32, fits: bool) -> vec4<f32> {
    let stride = i32(frame.stride.x);
    let first = vec2<i32>(pixel) / stride - (cells - 1);
    var sum = vec4(0.0);
    for (var i = 0; i < 4 * cells * cells; i++) {
        let texel = first + vec2(i % (2 * cells), i / (2 * cells));
        let other = texel * stride;
        if any(texel < vec2(0)) || any(other >= vec2<i32>(frame.size)) {
            continue;
        }
        let away = abs(vec2<f32>(other - vec2<i32>(pixel))) / f32(cells * stride);
        let tent = max(1.0 - away, vec2(0.0));
        let g = textureLoad(geometry, other, 0);
        if !(tent.x * tent.y > 0.0) || !is_surface(g) {
            continue;
        }
        let there = guide(g, vec2<u32>(other));
        let loose = select(OTHER, 1.0, there.material == here.material);
        let weight = tent.x * tent.y * select(loose, fit(here, there), fits);
        let samples = f32(max(sample_count(textureLoad(lattice_work, texel, 0)), 1u));
        let value = textureLoad(lattice_value, texel, 0).xyz / samples;
        sum += vec4(value / there.divisor, 1.0) * weight;
    }
    return sum;
}

// Twin of `Guide::fit`.
fn fit(here: Guide, there: Guide) -> f32 {
    if there.material != here.material {
        return 0.0;
    }
    let pixel_angle = 2.0 * frame.tan_half_fov / f32(frame.size.y);
    let reach = f32(frame.stride.x) * pixel_angle * distance(here.position, frame.eye);
    let plane = 1.0 - abs(dot(here.smooth_normal, there.position - here.position)) / reach;
    let turned = 2.0 * dot(here.normal, there.normal) - 1.0;
    if !(plane > 0.0 && turned > 0.0) {
        return 0.0;
    }
    let a = dot(here.albedo, LUMINANCE);
    let b = dot(there.albedo, LUMINANCE);
    return plane * turned * (min(a, b) / max(a, b));
}
