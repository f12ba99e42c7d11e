// A part of a picture's light, kept for the next picture from another camera: reverse reprojection (Nehab et al. 2007). Twin of
// `History` in render/src/cpu/sketch/history.rs.

struct Past {
    // Radiance over albedo, and the material; a negative material for pixels without a surface to shade.
    @location(0) value: vec4<f32>,
    // Bits of the position in meters, and the normal after bump and normal map in 8 bits per component.
    @location(1) place: vec4<u32>,
}

fn past_at(value: vec3<f32>, seen: Guide) -> Past {
    let normal = pack4x8snorm(vec4(seen.normal, 0.0));
    return Past(vec4(value, f32(seen.material)), vec4(bitcast<vec3<u32>>(seen.position), normal));
}

// How well a pixel of the last picture represents the light here, 0 to 1; `reach` is its size in meters.
fn fit_past(here: Guide, past: Past, reach: f32) -> f32 {
    if past.value.w < 0.0 {
        return 0.0;
    }
    let normal = normalize(unpack4x8snorm(past.place.w).xyz);
    return fit_surface(here, u32(past.value.w), bitcast<vec3<f32>>(past.place.xyz), normal, reach);
}
