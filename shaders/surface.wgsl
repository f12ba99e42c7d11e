// The hit of a camera ray: barycentric weights, the frame before bump and normal map, texture coordinates.
// Twin of render/src/shade/surface.rs.

// Intersection of a ray with a triangle's plane.
struct Hit {
    // Weights of the three corners, with a sum of one.
    barycentric: vec3<f32>,
    // 1 if the front is visible, -1 if the back is.
    side: f32,
}

// Weights from the edge planes through the eye, as in the ray caster.
fn hit_triangle(triangle: u32, direction: vec3<f32>) -> Hit {
    let corners = triangles[triangle].vertices;
    let a = vertices[corners.x].position - frame.eye;
    let b = vertices[corners.y].position - frame.eye;
    let c = vertices[corners.z].position - frame.eye;
    let back = dot(a, cross(b - a, c - a));
    let weights = vec3(dot(cross(b, c), direction), dot(cross(c, a), direction), dot(cross(a, b), direction));
    let sum = weights.x + weights.y + weights.z;
    return Hit(weights / sum, select(1.0, -1.0, back > 0.0));
}

// Texture coordinates of the three corners, in a set.
fn corner_uvs(corners: vec3<u32>, uv_set: u32) -> array<vec2<f32>, 3> {
    if uv_set == SECOND_UVS {
        return array(vertices[corners.x].second_uv, vertices[corners.y].second_uv, vertices[corners.z].second_uv);
    }
    return array(vertices[corners.x].uv, vertices[corners.y].uv, vertices[corners.z].uv);
}

// Texture coordinates of a point, and their change to the next samples on the right and below.
struct UvFootprint {
    uv: vec2<f32>,
    right: vec2<f32>,
    below: vec2<f32>,
}

fn point_footprint(uv: vec2<f32>) -> UvFootprint {
    return UvFootprint(uv, vec2(0.0), vec2(0.0));
}

// What the vertices give a material at a point. Twin of core/src/material/attributes.rs.
struct SurfaceAttributes {
    uv: UvFootprint,
    second_uv: UvFootprint,
    // Linear color; white where the mesh has none.
    color: vec3<f32>,
}

const READS_SECOND_UVS: u32 = 1u;
const READS_VERTEX_COLORS: u32 = 2u;

const FIRST_UVS: u32 = 0u;
const SECOND_UVS: u32 = 1u;

struct Slopes {
    per_u: vec3<f32>,
    per_v: vec3<f32>,
    is_regular: bool,
}

// Gradients of u and v along a triangle: the surface gradient of a function is per_u df/du + per_v df/dv.
fn surface_slopes(corners: vec3<u32>, uvs: array<vec2<f32>, 3>) -> Slopes {
    let p = vertices[corners.x].position;
    let e1 = vertices[corners.y].position - p;
    let e2 = vertices[corners.z].position - p;
    let d1 = uvs[1] - uvs[0];
    let d2 = uvs[2] - uvs[0];
    let n = cross(e1, e2);
    let area_sq = dot(n, n);
    // Gradients of the barycentric weights of the second and third corner.
    let gb = cross(e2, n) / area_sq;
    let gc = cross(n, e1) / area_sq;
    return Slopes(gb * d1.x + gc * d2.x, gb * d1.y + gc * d2.y, area_sq > 0.0);
}

// The footprint of a sample. Twin of render/src/shade/differentials.rs.
fn footprint_at(corners: vec3<u32>, b: vec3<f32>, uv_set: u32) -> UvFootprint {
    let uvs = corner_uvs(corners, uv_set);
    let uv = uvs[0] * b.x + uvs[1] * b.y + uvs[2] * b.z;
    let slopes = surface_slopes(corners, uvs);
    if !slopes.is_regular {
        return point_footprint(uv);
    }
    let p = vertices[corners.x].position;
    let normal = cross(vertices[corners.y].position - p, vertices[corners.z].position - p);
    let away = interpolated_position(corners, b) - frame.eye;
    let depth = -dot(away, frame.world_from_view[2]);
    let size = pixel_span(depth) * frame.sample_distance;
    let right = along_plane(frame.world_from_view[0] * size, away, normal);
    let below = along_plane(-frame.world_from_view[1] * size, away, normal);
    return UvFootprint(uv, change_of_uv(slopes, right), change_of_uv(slopes, below));
}

// The attributes that a material reads, see READS_*; the others are not looked up.
fn attributes_at(corners: vec3<u32>, b: vec3<f32>, reads: u32) -> SurfaceAttributes {
    let first = footprint_at(corners, b, FIRST_UVS);
    var attributes = SurfaceAttributes(first, first, vec3(1.0));
    if (reads & READS_SECOND_UVS) != 0u {
        attributes.second_uv = footprint_at(corners, b, SECOND_UVS);
    }
    if (reads & READS_VERTEX_COLORS) != 0u {
        attributes.color =
            vertex_color(corners.x) * b.x + vertex_color(corners.y) * b.y + vertex_color(corners.z) * b.z;
    }
    return attributes;
}

fn vertex_color(vertex: u32) -> vec3<f32> {
    let words = vertices[vertex].color;
    return vec3(unpack2x16unorm(words.x), unpack2x16unorm(words.y).x);
}

// Displacement on a plane for a displacement across the ray.
fn along_plane(across: vec3<f32>, away: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return across - away * (dot(normal, across) / dot(normal, away));
}

fn change_of_uv(slopes: Slopes, moved: vec3<f32>) -> vec2<f32> {
    return vec2(dot(slopes.per_u, moved), dot(slopes.per_v, moved));
}

fn interpolated_position(corners: vec3<u32>, b: vec3<f32>) -> vec3<f32> {
    return vertices[corners.x].position * b.x + vertices[corners.y].position * b.y + vertices[corners.z].position * b.z;
}

fn interpolated_tangent(corners: vec3<u32>, b: vec3<f32>) -> vec3<f32> {
    return vertices[corners.x].tangent * b.x + vertices[corners.y].tangent * b.y + vertices[corners.z].tangent * b.z;
}

// Interpolated normal before bump and normal map, on the visible side.
fn smooth_normal(corners: vec3<u32>, hit: Hit, wo: vec3<f32>) -> vec3<f32> {
    let b = hit.barycentric;
    let sum = vertices[corners.x].normal * b.x + vertices[corners.y].normal * b.y + vertices[corners.z].normal * b.z;
    let p = vertices[corners.x].position;
    let face = cross(vertices[corners.y].position - p, vertices[corners.z].position - p);
    return facing(normalize_or(sum * hit.side, normalize_or(face * hit.side, wo)), wo);
}

const LEAST_COS: f32 = 0.02;

// The normal, bent just enough to face the eye.
fn facing(normal: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let cos_o = dot(normal, wo);
    if cos_o >= LEAST_COS {
        return normal;
    }
    return normalize(normal + wo * (LEAST_COS - cos_o));
}

fn normalize_or(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let length_sq = dot(v, v);
    if !(length_sq > 1e-30) {
        return fallback;
    }
    return v * (1.0 / sqrt(length_sq));
}

// A frame around `normal`, with its first axis as close to `tangent` as possible.
fn frame_around(normal: vec3<f32>, tangent: vec3<f32>, handedness: f32) -> mat3x3<f32> {
    let t = normalize_or(tangent - normal * dot(normal, tangent), any_orthonormal(normal));
    return mat3x3<f32>(t, cross(normal, t) * handedness, normal);
}

// Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
fn any_orthonormal(n: vec3<f32>) -> vec3<f32> {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    return vec3(n.x * n.y * a, s + n.y * n.y * a, -n.y);
}

// Barycentric weights, with the weight of buried vertices given to the others.
fn valid_weights(corners: vec3<u32>, b: vec3<f32>) -> vec3<f32> {
    let valid = vec3(vertices[corners.x].is_valid, vertices[corners.y].is_valid, vertices[corners.z].is_valid);
    let kept = select(vec3(0.0), max(b, vec3(0.0)), valid != vec3(0u));
    let sum = kept.x + kept.y + kept.z;
    if sum > 1e-6 {
        return kept / sum;
    }
    return b;
}
