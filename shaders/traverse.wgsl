// Tests rays against a scene's triangles by traversing its box hierarchy. Twin of core/src/ray.rs: the same predicate, term by
// term. A program declares the hierarchy: `nodes`, and nine numbers per triangle, `corners`.

struct BoxNode {
    low: vec3<f32>,
    // First triangle of a leaf, or first of two children.
    first: u32,
    high: vec3<f32>,
    // Triangles of a leaf; 0 for other nodes.
    triangles: u32,
}

// Most waiting nodes: one per level, and the deepest.
const MOST_LEVELS: u32 = 64u;

fn corner_of(triangle: u32, corner: u32) -> vec3<f32> {
    let at = 9u * triangle + 3u * corner;
    return vec3(corners[at], corners[at + 1u], corners[at + 2u]);
}

// How far a ray lies within each edge of a triangle, seen from its origin; and, as w, how far the origin lies off its plane: 0 for a
// ray from its plane, above 0 behind it.
fn crossing(triangle: u32, origin: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let p = corner_of(triangle, 0u);
    let q = corner_of(triangle, 1u);
    let r = corner_of(triangle, 2u);
    let a = p - origin;
    let b = q - origin;
    let c = r - origin;
    let side = ordered_dot(a, cross(q - p, r - p));
    let facing = select(1.0, -1.0, side < 0.0);
    let u = facing * ordered_dot(cross(b, c), direction);
    let v = facing * ordered_dot(cross(c, a), direction);
    let w = facing * ordered_dot(cross(a, b), direction);
    return vec4(u, v, w, side);
}

// Whether a ray crosses a triangle. A ray from its plane never does.
fn crosses(at: vec4<f32>) -> bool {
    return at.w != 0.0 && all(at.xyz >= vec3(0.0));
}

fn enters(node: u32, origin: vec3<f32>, inverse: vec3<f32>) -> bool {
    return enters_before(node, origin, inverse, 3.4e38);
}

// Whether a ray enters a box before some distance.
fn enters_before(node: u32, origin: vec3<f32>, inverse: vec3<f32>, distance: f32) -> bool {
    let a = (nodes[node].low - origin) * inverse;
    let b = (nodes[node].high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let entry = max(max(near.x, near.y), max(near.z, 0.0));
    let leave = min(min(far.x, far.y), far.z);
    return entry <= min(leave * (1.0 + 1e-6), distance);
}

// One over each component, kept finite so that zero times it is zero.
fn inverse_of(direction: vec3<f32>) -> vec3<f32> {
    let signs = select(vec3(-1.0), vec3(1.0), direction >= vec3(0.0));
    return 1.0 / select(direction, 1e-18 * signs, abs(direction) < vec3(1e-18));
}

// Whether a ray hits anything.
fn is_occluded(origin: vec3<f32>, direction: vec3<f32>) -> bool {
    return occluder(origin, direction) != NO_NODE;
}

const NO_NODE: u32 = 0xffffffffu;

// Whether a ray hits a triangle of a leaf.
fn hits_leaf(leaf: u32, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    let first = nodes[leaf].first;
    for (var i = 0u; i < nodes[leaf].triangles; i++) {
        if crosses(crossing(first + i, origin, direction)) {
            return true;
        }
    }
    return false;
}

// A leaf with a triangle that a ray hits, or NO_NODE.
fn occluder(origin: vec3<f32>, direction: vec3<f32>) -> u32 {
    let inverse = inverse_of(direction);
    var waiting: array<u32, MOST_LEVELS>;
    var count = 0u;
    var node = 0u;
    if !enters(0u, origin, inverse) {
        return NO_NODE;
    }
    loop {
        let first = nodes[node].first;
        var next = 0u;
        if nodes[node].triangles > 0u {
            if hits_leaf(node, origin, direction) {
                return node;
            }
        } else {
            let one = enters(first, origin, inverse);
            let other = enters(first + 1u, origin, inverse);
            if one && other {
                let along = nodes[first + 1u].low + nodes[first + 1u].high - nodes[first].low - nodes[first].high;
                let is_other_near = dot(along, direction) < 0.0;
                waiting[count] = select(first + 1u, first, is_other_near);
                count++;
                next = select(first, first + 1u, is_other_near);
            } else if one {
                next = first;
            } else if other {
                next = first + 1u;
            }
        }
        // The root is not a child.
        if next == 0u {
            if count == 0u {
                return NO_NODE;
            }
            count--;
            next = waiting[count];
        }
        node = next;
    }
    return NO_NODE;
}

// The first hit of a ray.
struct FirstHit {
    // The triangle plus 1; 0 if there is none.
    triangle: u32,
    distance: f32,
    // Weights of the second and the third corner.
    barycentric: vec2<f32>,
    is_back: bool,
}

const NO_HIT: FirstHit = FirstHit(0u, 3.4e38, vec2(0.0), false);

// The nearer of a known hit and that on a triangle. Twin of `TriangleFrom::hit`.
fn nearer_hit(known: FirstHit, triangle: u32, origin: vec3<f32>, direction: vec3<f32>) -> FirstHit {
    let at = crossing(triangle, origin, direction);
    if !crosses(at) {
        return known;
    }
    let p = corner_of(triangle, 0u);
    let normal = cross(corner_of(triangle, 1u) - p, corner_of(triangle, 2u) - p);
    let sum = at.x + at.y + at.z;
    let distance = dot(p - origin, normal) / dot(direction, normal);
    if sum > 0.0 && distance > 0.0 && distance < known.distance {
        return FirstHit(triangle + 1u, distance, at.yz / sum, at.w > 0.0);
    }
    return known;
}

fn first_hit(origin: vec3<f32>, direction: vec3<f32>) -> FirstHit {
    return hit_before(NO_HIT.distance, false, origin, direction);
}

// The first hit of a ray before some distance, or any.
fn hit_before(reach: f32, any: bool, origin: vec3<f32>, direction: vec3<f32>) -> FirstHit {
    let inverse = inverse_of(direction);
    var hit = NO_HIT;
    hit.distance = reach;
    var waiting: array<u32, MOST_LEVELS>;
    waiting[0] = 0u;
    var count = 1u;
    while count > 0u && !(any && hit.triangle != 0u) {
        count--;
        let node = waiting[count];
        if !enters_before(node, origin, inverse, hit.distance) {
            continue;
        }
        let first = nodes[node].first;
        let triangles = nodes[node].triangles;
        for (var i = 0u; i < triangles; i++) {
            hit = nearer_hit(hit, first + i, origin, direction);
        }
        if triangles == 0u {
            let along = nodes[first + 1u].low + nodes[first + 1u].high - nodes[first].low - nodes[first].high;
            let is_other_near = dot(along, direction) < 0.0;
            // The nearer is taken first.
            waiting[count] = select(first + 1u, first, is_other_near);
            waiting[count + 1u] = select(first, first + 1u, is_other_near);
            count += 2u;
        }
    }
    return hit;
}
