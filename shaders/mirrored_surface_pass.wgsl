// Mirrors, pass 2: the surface that each ray of a mirror meets, as surface_pass.wgsl writes what the camera sees. Twin of
// `SeenScene::mirrored` in render/src/shade/seen_scene.rs.

struct MirroredScene {
    // First triangle of a ground; a number above all triangles without one.
    ground: u32,
    // Whether mirrors show the ground from above. From below they never do.
    shows_ground: u32,
    // Largest offset in meters of rays from their surface.
    largest_offset: f32,
    padding: u32,
}

@group(2) @binding(0) var<uniform> mirrored: MirroredScene;
@group(2) @binding(1) var<storage, read> nodes: array<BoxNode>;
// Nine numbers per triangle, in the order of the hierarchy's leaves, and their triangles.
@group(2) @binding(2) var<storage, read> corners: array<f32>;
@group(2) @binding(3) var<storage, read> leaf_triangles: array<u32>;
// Of the surfaces with mirrors.
@group(2) @binding(4) var geometry: texture_2d<u32>;
// Directions and weights of rays, with their cones.
@group(2) @binding(5) var mirror_rays: texture_2d<f32>;
@group(2) @binding(6) var mirror_weights: texture_2d<f32>;

// Thin surfaces and hidden grounds that a ray may pass.
const MOST_PASSED: u32 = 16u;

fn written_at(at: vec2<u32>) -> Surface {
    let ray = textureLoad(mirror_rays, at, 0);
    if ray.w == 0.0 {
        return NO_SURFACE;
    }
    let pixel = at * frame.stride;
    let seen = textureLoad(geometry, pixel, 0);
    let start = ray_start(seen, ray.xyz, mirrored.largest_offset);
    let direction = above(start.normal, ray.xyz);
    let hit = mirrored_hit(start.origin, direction, pixel);
    if hit.triangle == 0u {
        return NO_SURFACE;
    }
    let weights = vec3(1.0 - hit.barycentric.x - hit.barycentric.y, hit.barycentric);
    var surface = surface_seen(hit.triangle, Hit(weights, select(1.0, -1.0, hit.is_back)), direction);
    let width = textureLoad(mirror_weights, at, 0).w + ray.w * hit.distance;
    surface.geometry.w |= bitcast<u32>(width) & WIDTH_BITS;
    return surface;
}

const OF_MIRRORS: u32 = 0x5bd10000u;

// A direction, bent just enough to leave a face. Twin of `above` in render/src/shade/mirrors.rs.
fn above(normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let cosine = dot(direction, normal);
    if cosine >= 1e-3 {
        return direction;
    }
    return normalize(direction + normal * (1e-3 - cosine));
}

// The first hit of what a mirror shows: not of a hidden ground, nor of thin surfaces that let the ray through. Its triangle is that
// of the mesh.
fn mirrored_hit(origin: vec3<f32>, direction: vec3<f32>, pixel: vec2<u32>) -> FirstHit {
    var passed = 0.0;
    for (var i = 0u; i < MOST_PASSED; i += 1u) {
        var hit = first_hit(origin + direction * passed, direction);
        if hit.triangle == 0u {
            return hit;
        }
        let triangle = leaf_triangles[hit.triangle - 1u];
        let is_hidden = triangle >= mirrored.ground && (hit.is_back || mirrored.shows_ground == 0u);
        // Numbers other than the camera's: a mirror behind a pane shows the pane as often as others.
        let other = picture_pixel(pixel) ^ vec2(OF_MIRRORS + (frame.seen << 8u));
        if !is_hidden && !lets_through(triangle, uvs_at(triangle, hit.barycentric), other, frame.picture_sample) {
            hit.triangle = triangle + 1u;
            hit.distance += passed;
            return hit;
        }
        passed += hit.distance * (1.0 + 1e-5) + 0.01 * mirrored.largest_offset;
    }
    return NO_HIT;
}
