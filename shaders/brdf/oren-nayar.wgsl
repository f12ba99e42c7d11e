// Rough diffuse reflection that preserves energy. Twin of core/src/brdf/oren_nayar.rs.

struct OrenNayar {
    rough: RoughDiffuse,
}

fn oren_nayar_of(p: OrenNayarParameters) -> OrenNayar {
    return OrenNayar(rough_diffuse_of(p.base_color, p.diffuse_roughness));
}

fn oren_nayar_reflect(brdf: OrenNayar, light: Light, wo: vec3<f32>) -> vec3<f32> {
    return rough_diffuse_value(brdf.rough, light.wi, wo) * light.cosine;
}

fn oren_nayar_lobes(brdf: OrenNayar) -> mat3x2<f32> {
    return mat3x2(NO_LOBE, NO_LOBE, NO_LOBE);
}

fn oren_nayar_albedo(brdf: OrenNayar) -> vec3<f32> {
    return rough_diffuse_albedo(brdf.rough, 1.0);
}
