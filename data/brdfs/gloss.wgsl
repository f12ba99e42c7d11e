// Phong's highlight of 1975, made reciprocal and normalised (Lewis 1994), over a diffuse base. A BRDF for Lapidary.
//
// @parameter base_color | Base color | color | 0.2 0.3 0.5 | 0..1 | | Diffuse albedo.
// @parameter gloss | Gloss | number | 0.3 | 0..1 | | Share of light in the highlight.
// @parameter exponent | Exponent | number | 40 | 1..2000 | | Sharpness of the highlight.

fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let mirrored = vec3(-wo.xy, wo.z);
    let cosine = max(dot(mirrored, wi), 0.0);
    let highlight = (p.exponent + 2.0) / 6.2831853 * pow(cosine, p.exponent);
    return p.base_color * ((1.0 - p.gloss) / 3.14159265) + vec3(p.gloss * highlight);
}
