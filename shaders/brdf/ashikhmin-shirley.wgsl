// Ashikhmin and Shirley's anisotropic Phong model. Twin of core/src/brdf/ashikhmin_shirley.rs.

struct AshikhminShirley {
    alpha: vec2<f32>,
    slopes: vec2<f32>,
    schlick: Schlick,
}

fn ashikhmin_shirley_of(p: AshikhminShirleyParameters) -> AshikhminShirley {
    let alpha = lobe_alpha(p.roughness, p.anisotropy);
    return AshikhminShirley(alpha, slope_sq(alpha), schlick_of(p.base_color, p.metalness, p.ior, p.specular));
}

fn ashikhmin_shirley_base(brdf: AshikhminShirley) -> vec3<f32> {
    return brdf.schlick.diffuse * (1.0 - brdf.schlick.f0) * (28.0 / 23.0);
}

// 1 - (1 - cos / 2)^5.
fn ashikhmin_shirley_reached(cosine: f32) -> f32 {
    let m = 1.0 - 0.5 * cosine;
    let m2 = m * m;
    return 1.0 - m2 * m2 * m;
}

fn ashikhmin_shirley_reflect(brdf: AshikhminShirley, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light, wo);
    let filtered = phong_lobe(brdf.slopes, half);
    let cos_i = max(light.wi.z, 0.0);
    let cos_o = max(wo.z, 1e-4);
    let below = max(half.wi_dot_h, 1e-4) * max(cos_i, cos_o);
    let factor = filtered.two_exponents * (0.125 * FRAC_1_PI) / below;
    let lobe = select(0.0, factor * filtered.power * cos_i, light.is_above);
    let reached = ashikhmin_shirley_reached(cos_i) * ashikhmin_shirley_reached(cos_o);
    let base = ashikhmin_shirley_base(brdf) * FRAC_1_PI * (reached * light.cosine);
    return schlick_fresnel(brdf.schlick, half.wi_dot_h) * lobe + base;
}

fn ashikhmin_shirley_lobes(brdf: AshikhminShirley) -> mat3x2<f32> {
    return mat3x2(brdf.alpha, NO_LOBE, NO_LOBE);
}

fn ashikhmin_shirley_albedo(brdf: AshikhminShirley) -> vec3<f32> {
    let exponents = 2.0 / brdf.slopes;
    let n = sqrt(exponents.x * exponents.y);
    let kept = 2.0 * (n + 1.0) / (n + 3.0) * (1.0 - pow(0.5, 0.5 * (n + 3.0))) - (1.0 - pow(0.5, 0.5 * (n + 1.0)));
    return brdf.schlick.f0 * kept + ashikhmin_shirley_base(brdf) * (31.0 / 32.0 * 23.0 / 28.0);
}
