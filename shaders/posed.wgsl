// Light changes of posed objects, and bounced light at the vertices. Twin of `PosedLight` in render/src/light/implicit/posed_light.rs.

// Three planes, one below the other: growth, bounced irradiance, whose alpha is 1 for a moved vertex, and irradiance of uncovered
// surfaces. In each, row by row, front and back of one vertex after another. A single texel without poses.
@group(1) @binding(6) var posed: texture_2d<f32>;

const POSED_GROWTH: u32 = 0u;
const POSED_BOUNCE: u32 = 1u;
const POSED_UNCOVERED: u32 = 2u;
const POSED_PLANES: u32 = 3u;

fn is_any_posed() -> bool {
    return textureDimensions(posed).x > 1u;
}

fn posed_texel(vertex: u32, plane: u32, side: u32) -> vec4<f32> {
    let texel = 2u * vertex + side;
    let size = textureDimensions(posed);
    let first_row = plane * (size.y / POSED_PLANES);
    return textureLoad(posed, vec2(texel % size.x, first_row + texel / size.x), 0);
}

// Twin of `Sides::at`.
fn posed_at(point: SurfacePoint, plane: u32, from_behind: bool) -> vec3<f32> {
    let side = select(0u, 1u, from_behind);
    let v = point.vertices;
    let w = point.weights;
    return posed_texel(v.x, plane, side).xyz * w.x
        + posed_texel(v.y, plane, side).xyz * w.y
        + posed_texel(v.z, plane, side).xyz * w.z;
}

// Environment light from the baked light. Twin of `Painter::reflected`.
fn with_posed_ratio(point: SurfacePoint, from_behind: bool, as_baked: vec3<f32>) -> vec3<f32> {
    if !is_any_posed() {
        return as_baked;
    }
    let uncovered = rough_albedo(point, false) * posed_at(point, POSED_UNCOVERED, from_behind) * FRAC_1_PI;
    return as_baked * (1.0 + posed_at(point, POSED_GROWTH, from_behind)) + uncovered;
}

// Bounced light from the baked light. Twin of `Painter::bounced`.
fn with_posed_bounce(point: SurfacePoint, from_behind: bool, as_baked: vec3<f32>) -> vec3<f32> {
    if !is_any_posed() {
        return as_baked;
    }
    let has_moved = posed_texel(point.vertices.x, POSED_BOUNCE, 0u).w > 0.0;
    let more = rough_albedo(point, true) * posed_at(point, POSED_BOUNCE, from_behind) * FRAC_1_PI;
    return max(select(as_baked, vec3(0.0), has_moved) + more, vec3(0.0));
}
