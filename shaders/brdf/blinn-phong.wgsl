// Blinn and Phong's model, normalized, over a diffuse base. Twin of core/src/brdf/blinn_phong.rs.

struct BlinnPhong {
    alpha: f32,
    slopes: vec2<f32>,
    schlick: Schlick,
    base: DiffuseBase,
}

const LN_2: f32 = 0.6931472;

fn blinn_phong_of(p: BlinnPhongParameters) -> BlinnPhong {
    let alpha = lobe_alpha(p.roughness, 0.0);
    let schlick = schlick_of(p.base_color, p.metalness, p.ior, p.specular);
    let above = albedo_scaled(albedo_of_dielectric(vec2(0.0), p.ior), p.specular);
    return BlinnPhong(alpha.x, slope_sq(alpha), schlick, DiffuseBase(schlick.diffuse, above));
}

fn blinn_phong_reflect(brdf: BlinnPhong, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light, wo);
    let filtered = phong_lobe(brdf.slopes, half);
    let n = filtered.exponent;
    let factor = (n + 2.0) * (n + 4.0) * (0.125 * FRAC_1_PI) / (exp(-0.5 * LN_2 * n) + n);
    let lobe = select(0.0, factor * filtered.power * light.wi.z, light.is_above);
    return schlick_fresnel(brdf.schlick, half.wi_dot_h) * lobe + base_reflect(brdf.base, light, wo);
}

fn blinn_phong_lobes(brdf: BlinnPhong) -> mat3x2<f32> {
    return mat3x2(vec2(brdf.alpha), NO_LOBE, NO_LOBE);
}

fn blinn_phong_albedo(brdf: BlinnPhong) -> vec3<f32> {
    return brdf.schlick.f0 + base_albedo(brdf.base);
}
