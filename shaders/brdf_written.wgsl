// The structure and functions of a user's BRDF with number N. Twin of core/src/brdf/wgsl.rs, which has the constant.

struct WrittenN {
    p: written_N_of_Parameters,
    // Albedo for light from the normal, and width of the lobe.
    estimate: vec4<f32>,
}

fn written_N_of(p: written_N_of_Parameters, estimate: vec4<f32>) -> WrittenN {
    return WrittenN(p, estimate);
}

// Magenta if the value is not a reflectance.
fn written_N_value(p: written_N_of_Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let value = written_N_of_brdf(p, wi, wo);
    if !(all(value >= vec3(0.0)) && all(value <= vec3(1e6))) {
        return MISSING_ALBEDO * FRAC_1_PI;
    }
    return value;
}

fn written_N_above(wi: vec3<f32>) -> vec3<f32> {
    return normalize(vec3(wi.xy, max(wi.z, 1e-3)));
}

fn written_N_mean(brdf: WrittenN, wi: vec3<f32>, wo: vec3<f32>, inv_kappa: f32) -> vec3<f32> {
    let width = brdf.estimate.w;
    if !(width > 0.0 && inv_kappa > WIDE_LIGHT * width * width) {
        return written_N_value(brdf.p, wi, wo);
    }
    // Four directions with the variance of the light.
    let radius = min(sqrt(2.0 * inv_kappa), 1.0);
    let side = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(wi.z) > 0.9);
    let tangent = normalize(cross(wi, side));
    let bitangent = cross(wi, tangent);
    let sum = written_N_value(brdf.p, written_N_above(wi + radius * tangent), wo)
        + written_N_value(brdf.p, written_N_above(wi - radius * tangent), wo)
        + written_N_value(brdf.p, written_N_above(wi + radius * bitangent), wo)
        + written_N_value(brdf.p, written_N_above(wi - radius * bitangent), wo);
    return 0.25 * sum;
}

fn written_N_reflect(brdf: WrittenN, light: Light, wo: vec3<f32>) -> vec3<f32> {
    if !(light.cosine > 0.0) {
        return vec3(0.0);
    }
    return written_N_mean(brdf, written_N_above(light.wi), wo, light.inv_kappa + light.slopes.x + light.slopes.z)
        * light.cosine;
}

fn written_N_lobes(brdf: WrittenN) -> mat3x2<f32> {
    return mat3x2(vec2(brdf.estimate.w), NO_LOBE, NO_LOBE);
}

fn written_N_albedo(brdf: WrittenN) -> vec3<f32> {
    return brdf.estimate.xyz;
}
