// Light sources of a forest's leaves, and the leaves' light. Twin of `Lighting` and `LeafLight` in core/src/implicit/gather.rs.

const FRAC_1_PI: f32 = 0.318309886;

struct LightUniforms {
    // Cosine and sine of the frames' rotation.
    turn: vec2<f32>,
    // Whether to gather emission and sky rather than a bounce.
    is_first: u32,
    // Cells along one edge of a leaf's square.
    side: u32,
}

struct LeafLighting {
    // 0 to 1 per channel.
    reflectance: vec3<f32>,
    // Radiance.
    emitted: vec3<f32>,
    // Irradiance by light outside the bins.
    received: vec3<f32>,
}

// Irradiance.
struct LeafIrradiance {
    of_sky: vec3<f32>,
    // Irradiance by the sky and emission.
    direct: vec3<f32>,
    // Irradiance by all bounces so far.
    bounced: vec3<f32>,
    // Irradiance to reflect in the next bounce.
    last: vec3<f32>,
}
