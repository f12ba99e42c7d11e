// GGX with height-correlated shadowing (Heitz 2014) over a diffuse base. Twin of core/src/brdf/ggx.rs.

// Loss of a GGX lobe by shadowing and masking, for light from the normal: factors of the second to fourth power of
// alpha.
const LOBE_LOSS_2: f32 = 1.05;
const LOBE_LOSS_3: f32 = 1.75;
const LOBE_LOSS_4: f32 = -0.55;

struct Ggx {
    reflectance: Reflectance,
    alpha: vec2<f32>,
    // Squared widths of the lobe along tangent and bitangent, in projected slope space.
    slope_sq: vec2<f32>,
}

fn ggx_of(p: GgxParameters) -> Ggx {
    let alpha = lobe_alpha(p.roughness, p.anisotropy);
    let alpha_sq = min(alpha * alpha, vec2(0.9998));
    return Ggx(reflectance_of(p.base_color, p.metalness, p.ior, p.specular), alpha, alpha_sq / (1.0 - alpha_sq));
}

fn ggx_reflect(brdf: Ggx, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light.wi, wo, light.inv_kappa);
    let wi = light.wi;
    let a = half.spread + vec3(brdf.slope_sq.x, 0.0, brdf.slope_sq.y);
    let det_a = determinant_of(a);
    let scale = 1.0 / (1.0 + a.x + a.z + det_a);
    let m = vec3(a.x + det_a, a.y, a.z + det_a) * scale;
    let det = max(determinant_of(m), 1e-14);
    let h = half.h;
    let e = adjugate_quadratic(m, h.xy) / det + h.z * h.z;
    let d = FRAC_1_PI / (sqrt(det) * e * e);
    let cos_i = max(wi.z, 0.0);
    let cos_o = max(wo.z, 1e-4);
    let root_o = sqrt(cos_o * cos_o + quadratic(m, wo.xy));
    let root_i = sqrt(cos_i * cos_i + quadratic(m, wi.xy));
    let shadowed = 0.5 * cos_i / max(cos_i * root_o + cos_o * root_i, 1e-9);
    let fresnel = schlick(brdf.reflectance.f0, brdf.reflectance.f90, half.wi_dot_h);
    let lobe = select(0.0, d * shadowed, light.is_above);
    let diffuse = brdf.reflectance.diffuse * FRAC_1_PI;
    return (diffuse - diffuse * fresnel) * light.cosine + fresnel * lobe;
}

fn ggx_lobes(brdf: Ggx) -> vec3<f32> {
    return vec3(min(brdf.alpha.x, brdf.alpha.y), 0.0, 0.0);
}

fn ggx_albedo(brdf: Ggx) -> vec3<f32> {
    let f0 = brdf.reflectance.f0;
    let alpha = sqrt(brdf.alpha.x * brdf.alpha.y);
    let loss = alpha * alpha * (LOBE_LOSS_2 + LOBE_LOSS_3 * alpha + LOBE_LOSS_4 * alpha * alpha);
    return brdf.reflectance.diffuse * (1.0 - f0) + f0 / (1.0 + loss);
}
