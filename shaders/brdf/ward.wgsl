// Ward's BRDF of 1992 over a diffuse base. Twin of core/src/brdf/ward.rs.

struct Ward {
    alpha: vec2<f32>,
    specular: vec3<f32>,
    diffuse: vec3<f32>,
}

fn ward_of(p: WardParameters) -> Ward {
    let schlick = schlick_of(p.base_color, p.metalness, p.ior, p.specular);
    let f0 = schlick.f0;
    return Ward(lobe_alpha(p.roughness, p.anisotropy), f0, schlick.diffuse * (1.0 - max(f0.x, max(f0.y, f0.z))));
}

fn ward_reflect(brdf: Ward, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light, wo);
    let filtered = gaussian_lobe(brdf.alpha, half);
    let cos_i = max(light.wi.z, 0.0);
    let lobe = select(0.0, filtered.density * 0.25 * sqrt(cos_i / max(wo.z, 1e-4)), light.is_above);
    return brdf.diffuse * FRAC_1_PI * light.cosine + brdf.specular * lobe;
}

fn ward_lobes(brdf: Ward) -> mat3x2<f32> {
    return mat3x2(brdf.alpha, NO_LOBE, NO_LOBE);
}

fn ward_albedo(brdf: Ward) -> vec3<f32> {
    return brdf.diffuse + brdf.specular * albedo_at(albedo_of_row(ALBEDO_WARD, brdf.alpha), 1.0);
}
