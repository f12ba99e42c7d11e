// Locates the pixels of a picture in the last one, for one part of the light. Twin of `History::predict` in
// render/src/cpu/sketch/history.rs.

struct PastUniforms {
    // Right, up and backward axes of the camera.
    world_from_view: mat3x3<f32>,
    eye: vec3<f32>,
    // Distance of the picture plane from the eye in pixels.
    focal: f32,
    // Intersection of the axis with the picture, relative to the first pixel's sample.
    center: vec2<f32>,
    size: vec2<u32>,
}

// Not a uniform: Mesa 22.3 fails on it in a kernel.
@group(2) @binding(0) var<storage, read> past: PastUniforms;
@group(2) @binding(1) var past_value: texture_2d<f32>;
@group(2) @binding(2) var past_place: texture_2d<u32>;

// Radiance over albedo, and 1 if the last picture gives a value.
fn written_at(pixel: vec2<u32>) -> vec4<f32> {
    let g = textureLoad(geometry, pixel, 0);
    if !is_surface(g) {
        return vec4(0.0);
    }
    let here = guide(g, pixel);
    let view = (here.position - past.eye) * past.world_from_view;
    let depth = -view.z;
    if !(depth > 0.0) {
        return vec4(0.0);
    }
    let place = pixel_of_view(view, past.center, past.focal);
    let sum = told(here, place, depth / past.focal);
    if !(sum.w >= LEAST_SHARE) {
        return vec4(0.0);
    }
    return vec4(sum.xyz / sum.w, 1.0);
}

// Sum over the four pixels of the last picture around a position, and of their weights.
fn told(here: Guide, place: vec2<f32>, reach: f32) -> vec4<f32> {
    let first = floor(place);
    var sum = vec4(0.0);
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i % 2, i / 2);
        // Compared as floats: a position near the eye may exceed all integers.
        let pixel = first + vec2<f32>(corner);
        if !(all(pixel >= vec2(0.0)) && all(pixel < vec2<f32>(past.size))) {
            continue;
        }
        let tent = 1.0 - abs(place - pixel);
        let at = vec2<u32>(pixel);
        let known = Past(textureLoad(past_value, at, 0), textureLoad(past_place, at, 0));
        let weight = tent.x * tent.y * fit_past(here, known, reach);
        if weight > 0.0 {
            sum += vec4(known.value.xyz, 1.0) * weight;
        }
    }
    return sum;
}
