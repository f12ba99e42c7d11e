// The opaque part of OpenPBR Surface. Twin of core/src/brdf/openpbr.rs, which describes the layering.

struct OpenPbr {
    diffuse: RoughDiffuse,
    diffuse_scale: vec3<f32>,
    left_mean: f32,
    alpha: vec2<f32>,
    slopes: vec2<f32>,
    ior: f32,
    dielectric: vec3<f32>,
    metal: F82,
    tint: vec3<f32>,
    whole: Albedo,
    multiple: vec3<f32>,
    above: Albedo,
    coat_alpha: vec2<f32>,
    coat_slopes: vec2<f32>,
    coat_weight: f32,
    coat_ior: f32,
    coat_albedo: Albedo,
    fuzz: vec3<f32>,
    fuzz_roughness: f32,
    fuzz_albedo: Albedo,
}

// Schlick's Fresnel factor of a metal with its tint at 82 degrees.
struct F82 {
    f0: vec3<f32>,
    grazing: vec3<f32>,
    dip: vec3<f32>,
    weight: f32,
}

// Albedo of a missing layer.
const NO_ALBEDO: Albedo = Albedo(vec4<f32>(0.0), vec2<f32>(0.0));

const F82_COS: f32 = 0.14285715;
const LEAST_FUZZ_ROUGHNESS: f32 = 0.2;

fn f82_of(f0: vec3<f32>, tint: vec3<f32>, specular: f32, metalness: f32) -> F82 {
    let m = 1.0 - F82_COS;
    let m2 = m * m;
    let grazing = 1.0 - f0;
    let schlick = f0 + grazing * (m2 * m2 * m);
    return F82(f0, grazing, schlick * (1.0 - tint) / (F82_COS * m2 * m2 * m2), specular * metalness);
}

fn f82_fresnel(metal: F82, cosine: f32) -> vec3<f32> {
    let m = max(1.0 - cosine, 0.0);
    let m2 = m * m;
    let m5 = m2 * m2 * m;
    return max(metal.f0 + metal.grazing * m5 - metal.dip * (cosine * m5 * m), vec3(0.0)) * metal.weight;
}

fn openpbr_widths(roughness: f32, anisotropy: f32) -> vec2<f32> {
    let short = 1.0 - anisotropy;
    let long = roughness * roughness * sqrt(2.0 / (1.0 + short * short));
    return clamp(vec2(long, short * long), vec2(MIN_ALPHA), vec2(1.0));
}

fn openpbr_darkening(p: OpenPbrParameters, color: vec3<f32>, roughness: f32) -> vec3<f32> {
    let specular = albedo_of_dielectric(vec2(0.0), p.coat_ior);
    let inside_diffuse = 1.0 - (1.0 - specular.high.y) / (p.coat_ior * p.coat_ior);
    let inside_smooth = albedo_at(specular, 1.0);
    let spread = roughness + (1.0 - roughness) * (1.0 - p.base_metalness);
    let inside = inside_smooth + (inside_diffuse - inside_smooth) * spread;
    return mix(vec3(1.0), (1.0 - inside) / (1.0 - color * inside), p.coat_darkening);
}

fn openpbr_left(above: Albedo, coat: Albedo, fuzz: Albedo, cosine: f32) -> f32 {
    return (1.0 - albedo_at(above, cosine)) * (1.0 - albedo_at(coat, cosine)) * (1.0 - albedo_at(fuzz, cosine));
}

fn openpbr_of(p: OpenPbrParameters) -> OpenPbr {
    let base_4 = p.specular_roughness * p.specular_roughness * p.specular_roughness * p.specular_roughness;
    let coat_4 = p.coat_roughness * p.coat_roughness * p.coat_roughness * p.coat_roughness;
    let blurred = sqrt(sqrt(min(base_4 + 2.0 * coat_4, 1.0)));
    let roughness = p.specular_roughness + (blurred - p.specular_roughness) * p.coat_weight;
    let alpha = openpbr_widths(roughness, p.specular_roughness_anisotropy);
    let coat_alpha = openpbr_widths(p.coat_roughness, p.coat_roughness_anisotropy);
    let ratio = p.specular_ior / (1.0 + (p.coat_ior - 1.0) * p.coat_weight);
    let ior = max(ratio, 1.0 / ratio);
    let color = p.base_color * p.base_weight;
    let metal = f82_of(color, p.specular_color, p.specular_weight, p.base_metalness);
    let tinted = max(p.specular_color.x, max(p.specular_color.y, p.specular_color.z));
    let fuzzy = max(p.fuzz_color.x, max(p.fuzz_color.y, p.fuzz_color.z));
    let whole = albedo_of_row(ALBEDO_WHOLE, alpha);
    let mean_fresnel = metal.f0 + metal.grazing / 21.0 - metal.dip / 126.0;
    let multiple = multiple_reflectance(mean_fresnel, whole) * (metal.weight * albedo_normalization(whole));
    let above = albedo_scaled(albedo_of_dielectric(alpha, ior), p.specular_weight * tinted);
    var coat_albedo = NO_ALBEDO;
    var tint = vec3(1.0);
    if HAS_COAT {
        coat_albedo = albedo_scaled(albedo_of_dielectric(coat_alpha, p.coat_ior), p.coat_weight);
        tint = mix(tint, p.coat_color * openpbr_darkening(p, color, roughness), p.coat_weight);
    }
    var fuzz_albedo = NO_ALBEDO;
    if HAS_FUZZ {
        fuzz_albedo = albedo_scaled(albedo_of_width(ALBEDO_FUZZ, p.fuzz_roughness), p.fuzz_weight * fuzzy);
    }
    let left_mean = MEAN_WEIGHTS.x * openpbr_left(above, coat_albedo, fuzz_albedo, MEAN_NODES.x)
        + MEAN_WEIGHTS.y * openpbr_left(above, coat_albedo, fuzz_albedo, MEAN_NODES.y)
        + MEAN_WEIGHTS.z * openpbr_left(above, coat_albedo, fuzz_albedo, MEAN_NODES.z);
    return OpenPbr(
        rough_diffuse_of(color, p.base_diffuse_roughness),
        tint * ((1.0 - p.base_metalness) / max(left_mean, 1e-4)),
        left_mean,
        alpha,
        slope_sq(alpha),
        ior,
        p.specular_color * (p.specular_weight * (1.0 - p.base_metalness)),
        metal,
        tint,
        whole,
        multiple,
        above,
        coat_alpha,
        slope_sq(coat_alpha),
        p.coat_weight,
        p.coat_ior,
        coat_albedo,
        p.fuzz_color * p.fuzz_weight,
        p.fuzz_roughness,
        fuzz_albedo,
    );
}

fn openpbr_fresnel(brdf: OpenPbr, cosine: f32) -> vec3<f32> {
    let dielectric = brdf.dielectric * dielectric_fresnel(cosine, brdf.ior);
    if !HAS_METAL {
        return dielectric;
    }
    return f82_fresnel(brdf.metal, cosine) + dielectric;
}

// Fuzz (Estevez and Kulla 2017) times the cosine. Twin of core/src/brdf/fuzz.rs.
fn fuzz_lobe(roughness: f32, half: Half, light: Light, wo: vec3<f32>) -> f32 {
    let inverse = 1.0 / max(roughness, LEAST_FUZZ_ROUGHNESS);
    let sin_sq = max(1.0 - half.h.z * half.h.z, 1e-7);
    let d = exp(log(sin_sq) * (0.5 * inverse)) * ((2.0 + inverse) * 0.5 * FRAC_1_PI);
    let cos_i = max(light.wi.z, 0.0);
    let cos_o = max(wo.z, 1e-4);
    return d * 0.25 / max(cos_i + cos_o - cos_i * cos_o, 1e-4) * light.cosine;
}

fn openpbr_reflect(brdf: OpenPbr, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let half = half_vector(light, wo);
    let cos_i = light.wi.z;
    let glossy = openpbr_fresnel(brdf, half.wi_dot_h) * ggx_lobe(brdf.slopes, half, light, wo);
    let multiple = brdf.multiple * FRAC_1_PI * (albedo_left(brdf.whole, cos_i, wo.z) * light.cosine);
    let diffuse = rough_diffuse_value(brdf.diffuse, light.wi, wo)
        * (albedo_left(brdf.above, cos_i, wo.z) * light.cosine);
    var value = (glossy + multiple) * brdf.tint + diffuse * brdf.diffuse_scale;
    if HAS_COAT && brdf.coat_weight > 0.0 {
        let lobe = ggx_lobe(brdf.coat_slopes, half, light, wo) * dielectric_fresnel(half.wi_dot_h, brdf.coat_ior);
        value = value * albedo_left(brdf.coat_albedo, cos_i, wo.z) + vec3(lobe * brdf.coat_weight);
    }
    if HAS_FUZZ && any(brdf.fuzz > vec3(0.0)) {
        let lobe = fuzz_lobe(brdf.fuzz_roughness, half, light, wo);
        value = value * albedo_left(brdf.fuzz_albedo, cos_i, wo.z) + brdf.fuzz * lobe;
    }
    return value;
}

fn openpbr_lobes(brdf: OpenPbr) -> mat3x2<f32> {
    let coat = select(NO_LOBE, brdf.coat_alpha, brdf.coat_weight > 0.0);
    return mat3x2(brdf.alpha, coat, NO_LOBE);
}

fn openpbr_albedo(brdf: OpenPbr) -> vec3<f32> {
    let whole = albedo_at(brdf.whole, 1.0);
    let multiple = brdf.multiple * ((1.0 - whole) / albedo_normalization(brdf.whole));
    let glossy = (openpbr_fresnel(brdf, 1.0) * whole + multiple) * brdf.tint;
    let coat = 1.0 - albedo_at(brdf.coat_albedo, 1.0);
    let fuzz = 1.0 - albedo_at(brdf.fuzz_albedo, 1.0);
    let left = openpbr_left(brdf.above, brdf.coat_albedo, brdf.fuzz_albedo, 1.0) * brdf.left_mean;
    let diffuse = rough_diffuse_albedo(brdf.diffuse, 1.0) * brdf.diffuse_scale * left;
    let own_fuzz = albedo_at(albedo_of_width(ALBEDO_FUZZ, brdf.fuzz_roughness), 1.0);
    return glossy * (coat * fuzz * coat * fuzz) + diffuse + vec3((1.0 - coat) * fuzz * fuzz) + brdf.fuzz * own_fuzz;
}
