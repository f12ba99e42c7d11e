// Origin of rays, and their directions.
struct RayOrigin {
    origin: vec3<f32>,
    // Count directions whose cosine to the normal is greater, or all others.
    height: f32,
    normal: vec3<f32>,
    is_above: u32,
}

fn is_wanted(direction: vec3<f32>, at: RayOrigin) -> bool {
    return (ordered_dot(direction, at.normal) > at.height) == (at.is_above != 0u);
}
