// A user's BRDF whose file is missing: diffuse magenta. Available ones are in generated text for the scene. Twin of
// core/src/brdf/wgsl.rs.

struct Wgsl {
    albedo: vec3<f32>,
}

fn unwritten_of() -> Wgsl {
    return Wgsl(MISSING_ALBEDO);
}

fn unwritten_reflect(brdf: Wgsl, light: Light, wo: vec3<f32>) -> vec3<f32> {
    return brdf.albedo * (FRAC_1_PI * light.cosine);
}

fn unwritten_lobes(brdf: Wgsl) -> mat3x2<f32> {
    return mat3x2(NO_LOBE, NO_LOBE, NO_LOBE);
}

fn unwritten_albedo(brdf: Wgsl) -> vec3<f32> {
    return brdf.albedo;
}
