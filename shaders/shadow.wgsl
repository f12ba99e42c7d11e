// Views from lights, one for each layer of the shadow maps. Twin of render/src/gpu/shadows/view.rs.

struct ShadowView {
    origin: vec3<f32>,
    // The distance of depth 1 in meters; depth is 0 at infinity.
    depth_scale: f32,
    right: vec3<f32>,
    // Tangent of half the angle of view.
    half_width: f32,
    up: vec3<f32>,
    half_height: f32,
    forward: vec3<f32>,
    padding: u32,
}

@group(2) @binding(0) var<storage, read> shadow_views: array<ShadowView>;

// Components along right, up and forward.
fn shadow_local(view: ShadowView, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot(view.right, v), dot(view.up, v), dot(view.forward, v));
}

fn shadow_clip(view: ShadowView, local: vec3<f32>) -> vec4<f32> {
    let xy = local.xy / vec2(view.half_width, view.half_height);
    return vec4(xy, view.depth_scale, local.z);
}
