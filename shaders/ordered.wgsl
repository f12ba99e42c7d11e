// Vector products in glam's order of operations, for kernels that must decide like their twins: built-in ones may use any order.

fn ordered_dot(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn ordered_cross(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
}

fn ordered_length(a: vec3<f32>) -> f32 {
    return sqrt(ordered_dot(a, a));
}

// The unit vector, or `otherwise` if there is none. Twin of `Vec3::normalize_or`.
fn ordered_normalize_or(a: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let length = ordered_length(a);
    return select(otherwise, a * (1.0 / length), length > 0.0);
}
