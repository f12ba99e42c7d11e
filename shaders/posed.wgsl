// What posed objects change of the light: twin of `PosedLight` in render/src/light/implicit.rs.

// Four texels a vertex, row by row: the ratio on the front, with 1 in its alpha for a vertex that moved, that on the back, and the
// irradiance of bounces on both sides. A single texel where nothing is posed.
@group(1) @binding(6) var posed: texture_2d<f32>;

const RATIO: u32 = 0u;
const BOUNCE: u32 = 2u;

fn is_any_posed() -> bool {
    return textureDimensions(posed).x > 1u;
}

fn posed_texel(vertex: u32, value: u32) -> vec4<f32> {
    let texel = vertex * 4u + value;
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

// Factor of the environment's light.
fn posed_ratio(point: SurfacePoint, from_behind: bool) -> vec3<f32> {
    if !is_any_posed() {
        return vec3(1.0);
    }
    return posed_at(point, RATIO, from_behind);
}

// Bounced light from that as baked. Twin of `Painter::bounced`.
fn with_posed_bounce(point: SurfacePoint, from_behind: bool, as_baked: vec3<f32>) -> vec3<f32> {
    if !is_any_posed() {
        return as_baked;
    }
    let has_moved = posed_texel(point.vertices.x, RATIO).w > 0.0;
    let more = albedo_of(point.brdf) * posed_at(point, BOUNCE, from_behind) * FRAC_1_PI;
    return max(select(as_baked, vec3(0.0), has_moved) + more, vec3(0.0));
}
