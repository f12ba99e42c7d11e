// GGX microfacets with the energy lost between them, over a diffuse base. Twin of core/src/brdf/ggx.rs.

struct Ggx {
    alpha: vec2<f32>,
    slopes: vec2<f32>,
    surface: Interface,
    base: DiffuseBase,
    whole: Albedo,
    multiple: vec3<f32>,
}

fn ggx_of(p: GgxParameters) -> Ggx {
    let alpha = lobe_alpha(p.roughness, p.anisotropy);
    let surface = interface_of(p.base_color, p.edge_color, p.metalness, p.ior, p.specular);
    let whole = albedo_of_row(ALBEDO_WHOLE, alpha);
    let above = albedo_scaled(albedo_of_dielectric(alpha, p.ior), p.specular);
    let returned = multiple_reflectance(metal_mean(surface.metal), whole);
    let multiple = returned * (p.metalness * albedo_normalization(whole));
    return Ggx(
        alpha,
        slope_sq(alpha),
        surface,
        DiffuseBase(p.base_color * (1.0 - p.metalness), above),
        whole,
        multiple,
    );
}

fn ggx_reflect(brdf: Ggx, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light, wo);
    let single = interface_fresnel(brdf.surface, half.wi_dot_h) * ggx_lobe(brdf.slopes, half, light, wo);
    let multiple = brdf.multiple * FRAC_1_PI * (albedo_left(brdf.whole, light.wi.z, wo.z) * light.cosine);
    return single + multiple + base_reflect(brdf.base, light, wo);
}

fn ggx_lobes(brdf: Ggx) -> mat3x2<f32> {
    return mat3x2(brdf.alpha, NO_LOBE, NO_LOBE);
}

fn ggx_albedo(brdf: Ggx) -> vec3<f32> {
    let whole = albedo_at(brdf.whole, 1.0);
    let multiple = brdf.multiple * ((1.0 - whole) / albedo_normalization(brdf.whole));
    return interface_fresnel(brdf.surface, 1.0) * whole + multiple + base_albedo(brdf.base);
}
