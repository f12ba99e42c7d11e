// A BRDF of a user whose file is not there: diffuse magenta. Those that are there are in the text that is written for a scene.
// Twin of core/src/brdf/wgsl.rs.

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
