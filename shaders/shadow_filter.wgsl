// Visible share of a light at a receiver: percentage-closer filtering (Reeves et al. 1987) over 4 x 4 texels, weighted like 3 x 3
// bilinear lookups.
//
// Each texel is compared with the depth of the receiver's plane there (Isidoro 2006). Depth is affine over the map for any plane,
// even in perspective, so a surface never shadows itself, even in grazing light.

@group(2) @binding(2) var shadow_maps: texture_depth_2d_array;

// Radius of the kernel in texels.
const KERNEL_RADIUS: f32 = 2.0;
// Tangent of the largest angle of incidence at which neighboring faces are distinguished from blockers.
const STEEPEST: f32 = 6.0;

// A plane in a map.
struct Receiver {
    // Position on the map, -1 to 1.
    position: vec2<f32>,
    depth: f32,
    // Change of depth with position.
    slope: vec2<f32>,
    // Least depth of the plane nearby: it has none beyond the horizon of a curved surface.
    least: f32,
    // A blocker nearer than the plane by less than this is an adjacent face, as in the corner of a room.
    tolerance: f32,
}

fn shadow_receiver(view: ShadowView, local: vec3<f32>, n: vec3<f32>, facing: f32, size: f32) -> Receiver {
    let half = vec2(view.half_width, view.half_height);
    let clip = shadow_clip(view, local);
    let depth = clip.z / clip.w;
    let cos = facing / length(local);
    let tangent = sqrt(max(1.0 - cos * cos, 0.0)) / cos;
    let reach = KERNEL_RADIUS * 2.0 * max(half.x, half.y) * local.z / size;
    let before = reach * (1.0 + min(tangent, STEEPEST));
    let behind = reach * STEEPEST;
    let nearer = view.depth_scale / (local.z - min(before, 0.5 * local.z));
    let farther = view.depth_scale / (local.z + behind);
    return Receiver(clip.xy / clip.w, depth, -view.depth_scale / facing * n.xy * half, farther, nearer - depth);
}

// A face in a view; `facing` is at most 0 for faces turned away.
struct Faced {
    local: vec3<f32>,
    normal: vec3<f32>,
    facing: f32,
}

fn shadow_faced(view: ShadowView, position: vec3<f32>, normal: vec3<f32>) -> Faced {
    let local = shadow_local(view, position - view.origin);
    let n = shadow_local(view, normal);
    return Faced(local, n, -dot(n, local));
}

// Visible fraction of a view's light at a face with this normal, 0 to 1.
fn shadow_visibility(index: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let view = shadow_views[index];
    let face = shadow_faced(view, position, normal);
    // A face turned away is in its own shadow, whatever its interpolated normal.
    if !(face.facing > 0.0) {
        return 0.0;
    }
    let size = vec2<f32>(textureDimensions(shadow_maps));
    return shadow_filtered(index, shadow_receiver(view, face.local, face.normal, face.facing, size.x), size);
}

// Distance from a blocker to the receiver over the distance from the light to the blocker, 0 without one.
fn shadow_blocker(index: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let view = shadow_views[index];
    let face = shadow_faced(view, position, normal);
    if !(face.facing > 0.0) {
        return 0.0;
    }
    let size = vec2<f32>(textureDimensions(shadow_maps));
    let receiver = shadow_receiver(view, face.local, face.normal, face.facing, size.x);
    let texel = round(map_position(receiver, size));
    let stored = shadow_texel(texel, index, size);
    return select(0.0, stored / receiver.depth - 1.0, is_nearer(stored, nearest_depth(receiver, texel, size)));
}

// Position in texels; integers are texel centers.
fn map_position(receiver: Receiver, size: vec2<f32>) -> vec2<f32> {
    return (0.5 + vec2(0.5, -0.5) * receiver.position) * size - 0.5;
}

// Depth of the first surface, 0 without one. The maps cover the scene, not the ground beyond it.
fn shadow_texel(texel: vec2<f32>, index: u32, size: vec2<f32>) -> f32 {
    if any(texel < vec2(0.0)) || any(texel >= size) {
        return 0.0;
    }
    return textureLoad(shadow_maps, vec2<i32>(texel), index, 0);
}

// Whether a stored surface is nearer than a depth, which is negative far out on the ground.
fn is_nearer(stored: f32, depth: f32) -> bool {
    return stored > max(depth, 0.0);
}

// A surface with a larger depth at a texel blocks the receiver.
fn nearest_depth(receiver: Receiver, texel: vec2<f32>, size: vec2<f32>) -> f32 {
    let away = (texel - map_position(receiver, size)) * vec2(2.0, -2.0) / size;
    return max(receiver.depth + dot(receiver.slope, away), receiver.least) + receiver.tolerance;
}

fn shadow_filtered(index: u32, receiver: Receiver, size: vec2<f32>) -> f32 {
    let at = map_position(receiver, size);
    let base = floor(at);
    let f = at - base;
    let weights_x = vec4(1.0 - f.x, 1.0, 1.0, f.x);
    let weights_y = vec4(1.0 - f.y, 1.0, 1.0, f.y);
    var lit = 0.0;
    for (var j = 0; j < 4; j++) {
        for (var i = 0; i < 4; i++) {
            let texel = base + vec2(f32(i - 1), f32(j - 1));
            let is_blocked = is_nearer(shadow_texel(texel, index, size), nearest_depth(receiver, texel, size));
            lit += select(weights_x[i] * weights_y[j], 0.0, is_blocked);
        }
    }
    return lit / 9.0;
}
