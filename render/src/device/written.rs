//! The BRDFs that users wrote, as shaders have them: a module each, with names of its own, and what every model has.

use lapidary_core::brdf::{WIDE_LIGHT, Written};

/// What the names of a module begin with.
pub fn prefix(index: usize) -> String {
    format!("written_{index}_of_")
}

/// The module, the structure of a material's BRDF, and its functions. Twin of core/src/brdf/wgsl.rs.
pub fn text(written: &Written, index: usize) -> String {
    let module = prefix(index);
    // It was written once when it was read.
    let functions = written.wgsl(&module).unwrap_or_default();
    let name = format!("written_{index}");
    format!(
        "
{functions}
struct Written{index} {{
    p: {module}Parameters,
    // Albedo for light from the normal, and width of the lobe.
    estimate: vec4<f32>,
}}

fn {name}_of(p: {module}Parameters, estimate: vec4<f32>) -> Written{index} {{
    return Written{index}(p, estimate);
}}

// Magenta where it is no reflectance.
fn {name}_value(p: {module}Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {{
    let value = {module}brdf(p, wi, wo);
    if !(all(value >= vec3(0.0)) && all(value <= vec3(1e6))) {{
        return MISSING_ALBEDO * FRAC_1_PI;
    }}
    return value;
}}

fn {name}_above(wi: vec3<f32>) -> vec3<f32> {{
    return normalize(vec3(wi.xy, max(wi.z, 1e-3)));
}}

fn {name}_mean(brdf: Written{index}, wi: vec3<f32>, wo: vec3<f32>, inv_kappa: f32) -> vec3<f32> {{
    let width = brdf.estimate.w;
    if !(width > 0.0 && inv_kappa > {WIDE_LIGHT:?} * width * width) {{
        return {name}_value(brdf.p, wi, wo);
    }}
    // Four directions have the variance of the light.
    let radius = min(sqrt(2.0 * inv_kappa), 1.0);
    let side = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(wi.z) > 0.9);
    let tangent = normalize(cross(wi, side));
    let bitangent = cross(wi, tangent);
    let sum = {name}_value(brdf.p, {name}_above(wi + radius * tangent), wo)
        + {name}_value(brdf.p, {name}_above(wi - radius * tangent), wo)
        + {name}_value(brdf.p, {name}_above(wi + radius * bitangent), wo)
        + {name}_value(brdf.p, {name}_above(wi - radius * bitangent), wo);
    return 0.25 * sum;
}}

fn {name}_reflect(brdf: Written{index}, light: Light, wo: vec3<f32>) -> vec3<f32> {{
    if !(light.cosine > 0.0) {{
        return vec3(0.0);
    }}
    return {name}_mean(brdf, {name}_above(light.wi), wo, light.inv_kappa + light.slopes.x + light.slopes.z)
        * light.cosine;
}}

fn {name}_lobes(brdf: Written{index}) -> mat3x2<f32> {{
    return mat3x2(vec2(brdf.estimate.w), NO_LOBE, NO_LOBE);
}}

fn {name}_albedo(brdf: Written{index}) -> vec3<f32> {{
    return brdf.estimate.xyz;
}}
"
    )
}
