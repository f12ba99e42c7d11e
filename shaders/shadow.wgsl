// Views from lights, one for each layer of the shadow maps. Twin of render/src/gpu/shadows/view.rs.

struct ShadowView {
    origin: vec3<f32>,
    // Perspective: the distance of depth 1 in meters, with 0 at infinity. Parallel: the decrease of depth per meter.
    depth_scale: f32,
    right: vec3<f32>,
    // Perspective: tangent of half the angle of view; parallel: half the width in meters.
    half_width: f32,
    up: vec3<f32>,
    half_height: f32,
    forward: vec3<f32>,
    is_parallel: u32,
}

@group(2) @binding(0) var<storage, read> shadow_views: array<ShadowView>;

// Components along right, up and forward.
fn shadow_local(view: ShadowView, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot(view.right, v), dot(view.up, v), dot(view.forward, v));
}

fn shadow_clip(view: ShadowView, local: vec3<f32>) -> vec4<f32> {
    let xy = local.xy / vec2(view.half_width, view.half_height);
    if view.is_parallel != 0u {
        return vec4(xy, 1.0 - local.z * view.depth_scale, 1.0);
    }
    return vec4(xy, view.depth_scale, local.z);
}
