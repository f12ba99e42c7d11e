// The hit of a camera ray: barycentric weights, the frame before bump and normal map, texture coordinates.
// Twin of render/src/shade/surface.rs.

// Where a ray meets the plane of a triangle.
struct Hit {
    // Weights of the three corners; they add up to one.
    barycentric: vec3<f32>,
    // 1 if the front is seen, -1 if the back is.
    side: f32,
}

// Weights from the edge planes through the eye, as the ray caster has them.
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

fn interpolated_uv(corners: vec3<u32>, b: vec3<f32>) -> vec2<f32> {
    return vertices[corners.x].uv * b.x + vertices[corners.y].uv * b.y + vertices[corners.z].uv * b.z;
}

fn interpolated_position(corners: vec3<u32>, b: vec3<f32>) -> vec3<f32> {
    return vertices[corners.x].position * b.x + vertices[corners.y].position * b.y + vertices[corners.z].position * b.z;
}

fn interpolated_tangent(corners: vec3<u32>, b: vec3<f32>) -> vec3<f32> {
    return vertices[corners.x].tangent * b.x + vertices[corners.y].tangent * b.y + vertices[corners.z].tangent * b.z;
}

// Interpolated normal before bump and normal map, on the side that is seen.
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

// A frame around `normal` with its first axis along `tangent` as far as that is possible.
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

// Barycentric weights with those of buried vertices given to the others.
fn valid_weights(corners: vec3<u32>, b: vec3<f32>) -> vec3<f32> {
    let valid = vec3(vertices[corners.x].is_valid, vertices[corners.y].is_valid, vertices[corners.z].is_valid);
    let kept = select(vec3(0.0), max(b, vec3(0.0)), valid != vec3(0u));
    let sum = kept.x + kept.y + kept.z;
    if sum > 1e-6 {
        return kept / sum;
    }
    return b;
}
