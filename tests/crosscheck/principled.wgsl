// The principled BRDF of Burley 2012 with clearcoat and sheen, as Mitsuba's `principled` has it: Fresnel's equations for a
// dielectric of index 1.5, Schlick's approximation for a metal, and masking by Smith's factor, apart for light and eye.
//
// @parameter base_color | Base color | color | 0.5 0.2 0.1 | 0..1 | | Diffuse albedo, or the reflectance of a metal.
// @parameter roughness | Roughness | number | 0.5 | 0..1 | | Alpha is its square.
// @parameter metalness | Metalness | number | 0 | 0..1 | | 0 for a dielectric, 1 for a metal.
// @parameter clearcoat | Clearcoat | number | 0 | 0..1 | | A second highlight, which fades toward grazing angles.
// @parameter clearcoat_gloss | Clearcoat gloss | number | 0 | 0..1 | | Alpha goes from 0.1 to 0.001.
// @parameter sheen | Sheen | number | 0 | 0..1 | | Light of cloth toward grazing angles.

const PI = 3.14159265;
const IOR = 1.5;

fn schlick_weight(cosine: f32) -> f32 {
    let m = clamp(1.0 - cosine, 0.0, 1.0);
    return m * m * m * m * m;
}

fn fresnel(cosine: f32) -> f32 {
    let inner = sqrt(1.0 - (1.0 - cosine * cosine) / (IOR * IOR));
    let across = (cosine - IOR * inner) / (cosine + IOR * inner);
    let along = (IOR * cosine - inner) / (IOR * cosine + inner);
    return 0.5 * (across * across + along * along);
}

fn masking(cosine: f32, alpha: f32) -> f32 {
    let cos_sq = max(cosine * cosine, 1e-8);
    return 2.0 / (1.0 + sqrt(1.0 + alpha * alpha * (1.0 - cos_sq) / cos_sq));
}

fn diffuse(roughness: f32, cos_i: f32, cos_o: f32, cos_d: f32) -> f32 {
    let light = schlick_weight(cos_i);
    let eye = schlick_weight(cos_o);
    let retro = 2.0 * roughness * cos_d * cos_d;
    let returned = retro * (light + eye + light * eye * (retro - 1.0));
    return ((1.0 - 0.5 * light) * (1.0 - 0.5 * eye) + returned) / PI;
}

fn clearcoat(gloss: f32, cos_i: f32, cos_o: f32, cos_h: f32, cos_d: f32) -> f32 {
    let alpha = mix(0.1, 0.001, gloss);
    let rest = alpha * alpha - 1.0;
    let d = rest / (PI * log(alpha * alpha) * (1.0 + rest * cos_h * cos_h));
    return 0.25 * d * mix(schlick_weight(cos_d), 1.0, 0.04) * masking(cos_i, 0.25) * masking(cos_o, 0.25);
}

fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let h = normalize(wi + wo);
    let cos_d = dot(wi, h);
    let alpha = max(p.roughness * p.roughness, 0.001);
    let slope = (1.0 - h.z * h.z) / (alpha * alpha) + h.z * h.z;
    let d = 1.0 / (PI * alpha * alpha * slope * slope);
    let specular = d * masking(wi.z, alpha) * masking(wo.z, alpha) / max(4.0 * wi.z * wo.z, 1e-6);
    let metal = mix(p.base_color, vec3(1.0), schlick_weight(cos_d));
    let tint = p.metalness * metal + vec3((1.0 - p.metalness) * fresnel(cos_d));
    let base = p.base_color * diffuse(p.roughness, wi.z, wo.z, cos_d) + vec3(p.sheen * schlick_weight(cos_d));
    let coat = p.clearcoat * clearcoat(p.clearcoat_gloss, wi.z, wo.z, h.z, cos_d);
    return tint * specular + (1.0 - p.metalness) * base + vec3(coat);
}
