// Sixteen rays from a point to a sun. A cone around them comes first: where it is empty, or the first triangle that it meets is opaque and
// fills it, no ray is traced. Twin of core/src/ray/cones.rs.

struct Sun {
    // Unit direction to its center.
    axis: vec3<f32>,
    // One minus the cosine from center to rim; 0 for parallel light.
    height: f32,
    // Two unit vectors across.
    right: vec3<f32>,
    // Of the cone from axis to rim, widened by more than rays and planes are rounded.
    sine: f32,
    up: vec3<f32>,
    // Extent of the cone across its axis per meter along it.
    tangent: f32,
}

const MOST_SUNS: u32 = 8u;

struct SunUniforms {
    suns: array<Sun, MOST_SUNS>,
    count: u32,
    // Largest offset in meters of rays from their surface.
    largest_offset: f32,
    padding: vec2<u32>,
}

@group(2) @binding(0) var<uniform> suns: SunUniforms;
@group(2) @binding(1) var<storage, read> nodes: array<BoxNode>;
// Nine numbers per triangle, in the order of the hierarchy's leaves, and their triangles.
@group(2) @binding(2) var<storage, read> corners: array<f32>;
@group(2) @binding(3) var<storage, read> leaf_triangles: array<u32>;

// A point and the cone of its rays.
struct SunCone {
    origin: vec3<f32>,
    axis: vec3<f32>,
    inverse_axis: vec3<f32>,
    // Extent across the axis along each axis of space, per meter.
    widths: vec3<f32>,
    sine: f32,
}

fn sun_cone(sun: Sun, origin: vec3<f32>) -> SunCone {
    let across = sqrt(max(1.0 - sun.axis * sun.axis, vec3(0.0)));
    return SunCone(origin, sun.axis, inverse_of(sun.axis), sun.tangent * across, sun.sine);
}

// Whether the cone may enter a box: its axis enters the box enlarged by its width at the far end.
fn cone_enters(cone: SunCone, node: u32) -> bool {
    let middle = 0.5 * (nodes[node].low + nodes[node].high) - cone.origin;
    let half = 0.5 * (nodes[node].high - nodes[node].low);
    let far = max(dot(middle, cone.axis) + dot(half, abs(cone.axis)), 0.0);
    let enlarged = half + cone.widths * far;
    let a = (middle - enlarged) * cone.inverse_axis;
    let b = (middle + enlarged) * cone.inverse_axis;
    let near = min(a, b);
    let end = max(a, b);
    let entry = max(max(near.x, near.y), max(near.z, 0.0));
    return entry <= min(min(end.x, end.y), end.z) * (1.0 + 1e-6);
}

// Whether the cone lies wholly outside a plane through its apex (-1), wholly inside (1), or on both sides (0).
fn beside(cone: SunCone, normal: vec3<f32>, facing: f32) -> i32 {
    let distance = facing * dot(normal, cone.axis);
    let is_beyond = distance * distance > cone.sine * cone.sine * dot(normal, normal);
    return select(0, select(-1, 1, distance > 0.0), is_beyond);
}

// Whether a triangle is outside the cone (-1), fills it (1), or meets a part of it (0).
fn cone_meets(cone: SunCone, triangle: u32) -> i32 {
    let p = corner_of(triangle, 0u);
    let q = corner_of(triangle, 1u);
    let r = corner_of(triangle, 2u);
    let a = p - cone.origin;
    let b = q - cone.origin;
    let c = r - cone.origin;
    let side = dot(a, cross(q - p, r - p));
    // No ray from a triangle's plane meets it.
    if side == 0.0 {
        return -1;
    }
    let facing = select(1.0, -1.0, side < 0.0);
    let u = beside(cone, cross(b, c), facing);
    let v = beside(cone, cross(c, a), facing);
    let w = beside(cone, cross(a, b), facing);
    return min(min(u, v), w);
}

// Whether all rays within a cone meet nothing (1), all meet one triangle (-1), or neither is known (0).
fn seen_through(cone: SunCone) -> i32 {
    var waiting: array<u32, MOST_LEVELS>;
    var count = 0u;
    var node = 0u;
    if !cone_enters(cone, 0u) {
        return 1;
    }
    loop {
        let first = nodes[node].first;
        let triangles = nodes[node].triangles;
        var next = 0u;
        for (var i = 0u; i < triangles; i++) {
            let meets = cone_meets(cone, first + i);
            if meets >= 0 {
                return -meets;
            }
        }
        if triangles == 0u {
            let one = cone_enters(cone, first);
            let other = cone_enters(cone, first + 1u);
            if one && other {
                waiting[count] = first + 1u;
                count++;
            }
            next = select(select(0u, first + 1u, other), first, one);
        }
        // The root is not a child.
        if next == 0u {
            if count == 0u {
                return 1;
            }
            count--;
            next = waiting[count];
        }
        node = next;
    }
    return 1;
}

// Which rays to a sun meet nothing, a bit each. Those that come from below a surface with this normal do not count.
fn open_rays(sun: Sun, origin: vec3<f32>, normal: vec3<f32>, shift: vec2<f32>, pixel: vec2<u32>) -> u32 {
    let seen = seen_through(sun_cone(sun, origin));
    if seen > 0 {
        return ALL_RAYS;
    }
    if seen < 0 && !HAS_VEILS {
        return 0u;
    }
    var open = 0u;
    // What stopped the last ray stops most others.
    var blocker = NO_NODE;
    for (var i = 0u; i < RAYS_OF_SUN; i++) {
        let direction = direction_in(sun.axis, sun.right, sun.up, sun.height, place_of_ray(i, shift));
        if dot(direction, normal) > 0.0 {
            if HAS_VEILS {
                open |= select(1u << i, 0u, is_stopped(origin, direction, i, pixel));
            } else if blocker == NO_NODE || !hits_leaf(blocker, origin, direction) {
                blocker = occluder(origin, direction);
                open |= select(0u, 1u << i, blocker == NO_NODE);
            }
        }
        // Parallel light has but one ray.
        if sun.height == 0.0 && !HAS_VEILS {
            return open * ALL_RAYS;
        }
    }
    return open;
}

// Numbers other than those of the camera and of mirrors.
const OF_SUNS: u32 = 0x3d4f0000u;
// Thin surfaces that a ray may pass.
const MOST_VEILS: u32 = 16u;

// Whether a ray meets something that it does not pass.
fn is_stopped(origin: vec3<f32>, direction: vec3<f32>, ray: u32, pixel: vec2<u32>) -> bool {
    var passed = 0.0;
    for (var i = 0u; i < MOST_VEILS; i++) {
        let hit = first_hit(origin + direction * passed, direction);
        if hit.triangle == 0u {
            return false;
        }
        let triangle = leaf_triangles[hit.triangle - 1u];
        let sample = frame.picture_sample * RAYS_OF_SUN + ray;
        if !lets_through(triangle, uvs_at(triangle, hit.barycentric), pixel ^ vec2(OF_SUNS), sample) {
            return true;
        }
        passed += hit.distance * (1.0 + 1e-5) + 0.01 * suns.largest_offset;
    }
    return true;
}
