// The environment as seen directly: a latitude-longitude map, bilinear. Twin of Environment::radiance. A pass declares
// `environment_map`.

const PI: f32 = 3.14159265;

// The center of the map is +Z, its left quarter +X, its top +Y.
fn uv_from_direction(d: vec3<f32>) -> vec2<f32> {
    // On some adapters an arc cosine is less accurate than an arc tangent.
    return vec2(0.5 - atan2(d.x, d.z) / (2.0 * PI), atan2(length(d.xz), d.y) / PI);
}

// Rotates a world direction into the frame of the map.
fn to_environment(d: vec3<f32>) -> vec3<f32> {
    let turn = frame.environment_turn;
    return vec3(turn.y * d.x - turn.x * d.z, d.y, turn.x * d.x + turn.y * d.z);
}

fn environment_radiance(direction: vec3<f32>) -> vec3<f32> {
    let size = vec2<i32>(textureDimensions(environment_map));
    let p = uv_from_direction(to_environment(direction)) * vec2<f32>(size) - 0.5;
    let base = floor(p);
    let f = p - base;
    let low = vec2((i32(base.x) + size.x) % size.x, max(i32(base.y), 0));
    let high = vec2((low.x + 1) % size.x, min(i32(base.y) + 1, size.y - 1));
    let top = mix(environment_texel(low.x, low.y), environment_texel(high.x, low.y), f.x);
    let bottom = mix(environment_texel(low.x, high.y), environment_texel(high.x, high.y), f.x);
    return mix(top, bottom, f.y) * frame.environment_intensity;
}

fn environment_texel(x: i32, y: i32) -> vec3<f32> {
    return textureLoad(environment_map, vec2(x, y), 0).xyz;
}

// Radiance behind a ground that catches shadows.
fn caught_radiance(direction: vec3<f32>) -> vec3<f32> {
    if frame.caught == BACKGROUND_FLAT {
        return frame.caught_color;
    }
    return environment_radiance(direction);
}

// Radiance without a surface.
fn background_radiance(direction: vec3<f32>) -> vec3<f32> {
    if frame.background == BACKGROUND_FLAT {
        return frame.background_color;
    }
    return environment_radiance(direction);
}
