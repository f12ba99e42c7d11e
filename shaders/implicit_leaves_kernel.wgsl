// Light of leaves as the vertices beside them take it, one invocation each. Twin of `Seen::lit` in render/src/light/implicit.rs and
// of `Gloss::toward_eye` in render/src/light/implicit/gloss.rs.

// Least albedo of a channel whose gloss is compared with diffuse light.
const LEAST_GLOSSY_ALBEDO: f32 = 1e-4;
const PI: f32 = 3.14159265;

struct LeafUniforms {
    // Whether leaves count by their albedo, as beside gloss.
    weighs_albedo: u32,
    // Whether glossy leaves reflect toward the eye.
    has_reflected: u32,
}

// Irradiance.
struct Received {
    sky: vec3<f32>,
    others: vec3<f32>,
}

@group(1) @binding(0) var<uniform> uniforms: LeafUniforms;
@group(1) @binding(1) var<storage, read> lighting: array<LeafLighting>;
@group(1) @binding(2) var<storage, read> light: array<LeafIrradiance>;
@group(1) @binding(3) var<storage, read> reflected: array<Reflected>;
// Open share of each leaf.
@group(1) @binding(4) var<storage, read> open: array<f32>;
@group(1) @binding(5) var<storage, read_write> values: array<LeafValue>;

@compute @workgroup_size(64)
fn value_leaves(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let leaf = 64u * workgroup_number(group) + lane;
    if leaf >= arrayLength(&values) {
        return;
    }
    let albedo = lighting[leaf].reflectance;
    // The bins treat emissive surfaces as lamps; the picture counts them as bounced light.
    let others = light[leaf].direct - light[leaf].of_sky + light[leaf].bounced;
    let received = toward_eye(leaf, albedo, Received(light[leaf].of_sky, others));
    let weight = open[leaf] * select(vec3(1.0), albedo, uniforms.weighs_albedo != 0u);
    values[leaf] = LeafValue(received.sky * weight, open[leaf], received.others * weight, weight);
}

// The irradiance with which a diffuse leaf of the same albedo would reflect as much toward the eye.
fn toward_eye(leaf: u32, albedo: vec3<f32>, received: Received) -> Received {
    if uniforms.has_reflected == 0u || reflected[leaf].faces_eye == 0u {
        return received;
    }
    let irradiance = reflected[leaf].irradiance;
    let of_sky = irradiance_of(albedo, reflected[leaf].sky, received.sky);
    // Nodes send the light of one bounce more than leaves received: it gives the share alone.
    let share = irradiance_of(albedo, reflected[leaf].leaves, irradiance);
    let others = select(received.others, received.others * share / irradiance, irradiance > vec3(0.0));
    return Received(of_sky, others);
}

// Twin of `GlossyLeaf::irradiance`.
fn irradiance_of(albedo: vec3<f32>, radiance: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let least = vec3(LEAST_GLOSSY_ALBEDO);
    return select(otherwise, PI * radiance / max(albedo, least), albedo >= least);
}
