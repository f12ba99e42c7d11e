// Where rays from a surface start. Twin of `SurfacePoint::ray_origin` and of core/src/offset.rs.

struct RayStart {
    origin: vec3<f32>,
    // Of the face, on the visible side.
    normal: vec3<f32>,
}

const OF_EDGE: f32 = 0.02;

// `otherwise` is the normal of a face without one.
fn ray_start(g: vec4<u32>, otherwise: vec3<f32>, largest: f32) -> RayStart {
    let corners_of = triangles[g.x - 1u].vertices;
    let hit = hit_of(g);
    let a = vertices[corners_of.x].position;
    let b = vertices[corners_of.y].position;
    let c = vertices[corners_of.z].position;
    let normal = normalize_or(cross(b - a, c - a) * hit.side, otherwise);
    let edge = (distance(a, b) + distance(b, c) + distance(c, a)) / 3.0;
    let offset = clamp(OF_EDGE * edge, OF_EDGE * largest, largest);
    return RayStart(interpolated_position(corners_of, hit.barycentric) + normal * offset, normal);
}

// Both sets of texture coordinates on a triangle.
fn uvs_at(triangle: u32, bc: vec2<f32>) -> vec4<f32> {
    let corners = triangles[triangle].vertices;
    let b = vec3(1.0 - bc.x - bc.y, bc);
    let first = corner_uvs(corners, FIRST_UVS);
    let second = corner_uvs(corners, SECOND_UVS);
    return vec4(
        first[0] * b.x + first[1] * b.y + first[2] * b.z,
        second[0] * b.x + second[1] * b.y + second[2] * b.z,
    );
}
