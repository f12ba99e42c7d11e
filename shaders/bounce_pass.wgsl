// Bounced light of the meshless basis at the vertices, interpolated with the weights of their cuts. Twin of `Painter::interpolated` in render/src/shade/painter.rs.

struct VertexIrradiance {
    // Vector irradiance in W/m2, one column per colour channel.
    vector: mat3x3<f32>,
}

// One per vertex.
@group(2) @binding(0) var<storage, read> front_irradiance: array<VertexIrradiance>;
// For surfaces seen from behind: one per vertex, or a single one if no back receives light.
@group(2) @binding(1) var<storage, read> back_irradiance: array<VertexIrradiance>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Sums {
    let pixel = vec2<u32>(position.xy) * frame.stride;
    let sums = previous_sums(pixel);
    if !lacks_sample(sums) {
        return sums;
    }
    let g = textureLoad(geometry, pixel, 0);
    if !is_surface(g) {
        return with_sample(sums, g, vec4(0.0), 0u, 0u);
    }
    let point = surface_point(g, pixel, ray_direction(pixel));
    let value = albedo_of(point.brdf) * irradiance_at(point, (g.w & FLAG_BACK) != 0u) * FRAC_1_PI;
    return with_sample(sums, g, vec4(value, 0.0), 0u, 0u);
}

// Irradiance on the surface as bump and normal map have it.
fn irradiance_at(point: SurfacePoint, from_behind: bool) -> vec3<f32> {
    let v = point.vertices;
    let w = point.weights;
    let vector = vector_irradiance(v.x, from_behind) * w.x
        + vector_irradiance(v.y, from_behind) * w.y
        + vector_irradiance(v.z, from_behind) * w.z;
    return max(point.world_from_local[2] * vector, vec3(0.0));
}

// Twin of `VertexIrradiance::at`.
fn vector_irradiance(vertex: u32, from_behind: bool) -> mat3x3<f32> {
    if !from_behind {
        return front_irradiance[vertex].vector;
    }
    if vertex >= arrayLength(&back_irradiance) {
        return mat3x3<f32>();
    }
    return back_irradiance[vertex].vector;
}
