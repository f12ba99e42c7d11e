// Deferred pass 3: the BRDF's eight parameters, modulated by textures and clamped into their ranges. Twin of
// Material::modulated in core/src/material.rs.

@group(3) @binding(0) var geometry: texture_2d<u32>;
@group(3) @binding(1) var environment_map: texture_2d<f32>;

struct Parameters {
    // Base colour and roughness.
    @location(0) color_roughness: vec4<f32>,
    // Metalness, anisotropy, index of refraction, specular weight.
    @location(1) others: vec4<f32>,
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Parameters {
    let pixel = vec2<u32>(position.xy);
    let g = textureLoad(geometry, pixel, 0);
    if g.x == 0u {
        return Parameters(vec4(0.0), vec4(0.0));
    }
    if (g.w & FLAG_CATCHER) != 0u {
        return Parameters(vec4(caught_radiance(ray_direction(pixel)) * frame.caught_per_radiance, 1.0), vec4(0.0));
    }
    let triangle = triangles[g.x - 1u];
    let bc = bitcast<vec2<f32>>(g.yz);
    let uv = interpolated_uv(triangle.vertices, vec3(1.0 - bc.x - bc.y, bc));
    let m = materials[triangle.material & ~TWO_SIDED];
    var color = m.base_color;
    if m.base_color_map.kind != 0u {
        color *= sample_slot(m.base_color_map, uv).xyz;
    }
    let roughness = m.roughness * scalar_map(m.roughness_map, uv);
    let metalness = m.metalness * scalar_map(m.metalness_map, uv);
    let specular = m.specular * scalar_map(m.specular_map, uv);
    let anisotropy = m.anisotropy * scalar_map(m.anisotropy_map, uv);
    // 1 is no refraction: the map scales what is above it.
    var ior = m.ior;
    if m.ior_map.kind != 0u {
        ior = 1.0 + (m.ior - 1.0) * scalar_map(m.ior_map, uv);
    }
    return Parameters(
        saturate(vec4(color, roughness)),
        vec4(saturate(metalness), clamp(anisotropy, -1.0, 1.0), clamp(ior, 1.0, 10.0), saturate(specular)),
    );
}
