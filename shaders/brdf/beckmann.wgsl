// Cook-Torrance with Beckmann's distribution over a diffuse base. Twin of core/src/brdf/beckmann.rs.

struct Beckmann {
    alpha: vec2<f32>,
    surface: Interface,
    base: DiffuseBase,
}

fn beckmann_of(p: BeckmannParameters) -> Beckmann {
    let above = albedo_scaled(albedo_of_dielectric(vec2(0.0), p.ior), p.specular);
    return Beckmann(
        lobe_alpha(p.roughness, p.anisotropy),
        interface_of(p.base_color, p.edge_color, p.metalness, p.ior, p.specular),
        DiffuseBase(p.base_color * (1.0 - p.metalness), above),
    );
}

// Shadowing of one direction (Walter et al. 2007, Eq. 27).
fn beckmann_shadowing(alpha_sq: vec3<f32>, w: vec2<f32>, cosine: f32) -> f32 {
    let ratio = cosine / sqrt(max(quadratic(alpha_sq, w), 1e-12));
    let above = ratio * (3.535 + 2.181 * ratio);
    let below = 1.0 + ratio * (2.276 + 2.577 * ratio);
    return select(1.0, above / below, ratio < 1.6);
}

fn beckmann_reflect(brdf: Beckmann, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light, wo);
    let filtered = gaussian_lobe(brdf.alpha, half);
    let d = filtered.density / (filtered.cos_h_sq * filtered.cos_h_sq);
    let cos_o = max(wo.z, 1e-4);
    let shadowed = beckmann_shadowing(filtered.alpha_sq, light.wi.xy, max(light.wi.z, 0.0))
        * beckmann_shadowing(filtered.alpha_sq, wo.xy, cos_o);
    let lobe = select(0.0, d * shadowed * 0.25 / cos_o, light.is_above);
    return interface_fresnel(brdf.surface, half.wi_dot_h) * lobe + base_reflect(brdf.base, light, wo);
}

fn beckmann_lobes(brdf: Beckmann) -> mat3x2<f32> {
    return mat3x2(brdf.alpha, NO_LOBE, NO_LOBE);
}

fn beckmann_albedo(brdf: Beckmann) -> vec3<f32> {
    let kept = albedo_at(albedo_of_row(ALBEDO_BECKMANN, brdf.alpha), 1.0);
    return interface_fresnel(brdf.surface, 1.0) * kept + base_albedo(brdf.base);
}
