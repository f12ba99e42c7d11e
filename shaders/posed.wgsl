// Light changes of posed objects, and bounced light at the vertices. Twin of `PosedLight` in render/src/light/implicit.rs.

// Texels per vertex, row by row: growth on front and back, bounced irradiance, and irradiance of uncovered surfaces; alpha is 1 for
// a moved vertex. A single texel without poses.
@group(1) @binding(6) var posed: texture_2d<f32>;

const GROWTH: u32 = 0u;
const BOUNCE: u32 = 2u;
const UNCOVERED: u32 = 4u;
const POSED_TEXELS: u32 = 6u;

fn is_any_posed() -> bool {
    return textureDimensions(posed).x > 1u;
}

fn posed_texel(vertex: u32, value: u32) -> vec4<f32> {
    let texel = vertex * POSED_TEXELS + value;
    let width = textureDimensions(posed).x;
    return textureLoad(posed, vec2(texel % width, texel / width), 0);
}

// Twin of `Sides::at`.
fn posed_at(point: SurfacePoint, value: u32, from_behind: bool) -> vec3<f32> {
    let of_side = value + select(0u, 1u, from_behind);
    let v = point.vertices;
    let w = point.weights;
    return posed_texel(v.x, of_side).xyz * w.x + posed_texel(v.y, of_side).xyz * w.y + posed_texel(v.z, of_side).xyz * w.z;
}

// Environment light from the baked light. Twin of `Painter::reflected`.
fn with_posed_ratio(point: SurfacePoint, from_behind: bool, as_baked: vec3<f32>) -> vec3<f32> {
    if !is_any_posed() {
        return as_baked;
    }
    let uncovered = rough_albedo(point, false) * posed_at(point, UNCOVERED, from_behind) * FRAC_1_PI;
    return as_baked * (1.0 + posed_at(point, GROWTH, from_behind)) + uncovered;
}

// Bounced light from the baked light. Twin of `Painter::bounced`.
fn with_posed_bounce(point: SurfacePoint, from_behind: bool, as_baked: vec3<f32>) -> vec3<f32> {
    if !is_any_posed() {
        return as_baked;
    }
    let has_moved = posed_texel(point.vertices.x, GROWTH).w > 0.0;
    let more = rough_albedo(point, true) * posed_at(point, BOUNCE, from_behind) * FRAC_1_PI;
    return max(select(as_baked, vec3(0.0), has_moved) + more, vec3(0.0));
}
