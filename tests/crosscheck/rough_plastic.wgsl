// Mitsuba's `roughplastic`, not nonlinear: a diffuse base below a rough dielectric of index 1.5. TRANSMITTED stands for the share of
// light that the dielectric lets through at COUNT cosines from 0 to 1, and INSIDE for what it reflects of light from below;
// `files.py` integrates both for ALPHA.
//
// @parameter base_color | Base color | color | 0.5 0.2 0.1 | 0..1 | | Albedo of the base.

const PI = 3.14159265;
const IOR = 1.5;

fn fresnel(cosine: f32) -> f32 {
    let inner = sqrt(1.0 - (1.0 - cosine * cosine) / (IOR * IOR));
    let across = (cosine - IOR * inner) / (cosine + IOR * inner);
    let along = (IOR * cosine - inner) / (IOR * cosine + inner);
    return 0.5 * (across * across + along * along);
}

fn masking(cosine: f32) -> f32 {
    let cos_sq = max(cosine * cosine, 1e-8);
    return 2.0 / (1.0 + sqrt(1.0 + ALPHA * ALPHA * (1.0 - cos_sq) / cos_sq));
}

fn transmitted(cosine: f32) -> f32 {
    var table = array<f32, COUNT>(TRANSMITTED);
    let at = clamp(cosine, 0.0, 1.0) * (COUNT - 1.0);
    let low = min(u32(at), COUNT - 2u);
    return mix(table[low], table[low + 1u], at - f32(low));
}

fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let h = normalize(wi + wo);
    let slope = (1.0 - h.z * h.z) / (ALPHA * ALPHA) + h.z * h.z;
    let d = 1.0 / (PI * ALPHA * ALPHA * slope * slope);
    let specular = fresnel(dot(wi, h)) * d * masking(wi.z) * masking(wo.z) / max(4.0 * wi.z * wo.z, 1e-6);
    let passed = transmitted(wi.z) * transmitted(wo.z) / (IOR * IOR);
    return p.base_color * (passed / (PI * (1.0 - INSIDE))) + vec3(specular);
}
