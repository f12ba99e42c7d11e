// Velvet: a diffuse cloth whose fibres light up toward grazing angles, after Ashikhmin 2000. A BRDF for Lapidary.
//
// @parameter cloth_color | Cloth color | color | 0.25 0.02 0.05 | 0..1 | | Albedo of the cloth between the fibres.
// @parameter fibre_color | Fibre color | color | 0.5 0.25 0.3 | 0..1 | | What the fibres reflect.
// @parameter fibre_spread | Fibre spread | number | 0.35 | 0.1..1 | | How far the fibres stand from the normal, as a slope.

fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let h = normalize(wi + wo);
    let sin_sq = max(1.0 - h.z * h.z, 1e-4);
    let cot_sq = h.z * h.z / sin_sq;
    let lying = exp(-cot_sq / (p.fibre_spread * p.fibre_spread)) / (1.0 + 3.14159265 * p.fibre_spread * p.fibre_spread);
    let shadowed = 4.0 * (wi.z + wo.z - wi.z * wo.z);
    return p.cloth_color * (0.8 / 3.14159265) + p.fibre_color * (lying / shadowed) * 0.3;
}
