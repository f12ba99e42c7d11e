// Ideal diffuse reflection. Twin of core/src/brdf/lambert.rs.

struct Lambert {
    albedo: vec3<f32>,
}

fn lambert_of(p: LambertParameters) -> Lambert {
    return Lambert(p.base_color);
}

fn lambert_reflect(brdf: Lambert, light: Light, wo: vec3<f32>) -> vec3<f32> {
    return brdf.albedo * FRAC_1_PI * light.cosine;
}

fn lambert_lobes(brdf: Lambert) -> mat3x2<f32> {
    return mat3x2(NO_LOBE, NO_LOBE, NO_LOBE);
}

fn lambert_albedo(brdf: Lambert) -> vec3<f32> {
    return brdf.albedo;
}
