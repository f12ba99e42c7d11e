// Deferred pass 3: base colour and roughness, for the views that show them; of a ground that catches shadows its
// reflectance.

@group(2) @binding(0) var geometry: texture_2d<u32>;
@group(2) @binding(1) var environment_map: texture_2d<f32>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    let g = textureLoad(geometry, pixel, 0);
    if g.x == 0u {
        return vec4(0.0);
    }
    if (g.w & FLAG_CATCHER) != 0u {
        return vec4(caught_radiance(ray_direction(pixel)) * frame.caught_per_radiance, 1.0);
    }
    let triangle = triangles[g.x - 1u];
    let bc = bitcast<vec2<f32>>(g.yz);
    let uv = footprint_at(triangle.vertices, vec3(1.0 - bc.x - bc.y, bc));
    return color_and_roughness(triangle.material & ~TWO_SIDED, uv);
}
