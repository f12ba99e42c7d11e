// What lights the leaves of a forest, and their light. Twin of `Lighting` and `LeafLight` in core/src/implicit/gather.rs.

const FRAC_1_PI: f32 = 0.318309886;

struct LightUniforms {
    // Cosine and sine of the turn of the frames.
    turn: vec2<f32>,
    // Whether the light of what emits and of the sky is gathered, and not a bounce.
    is_first: u32,
    // Cells along an edge of the square of a leaf.
    side: u32,
}

struct LeafLighting {
    // 0 to 1 per channel.
    reflectance: vec3<f32>,
    // Radiance.
    emitted: vec3<f32>,
    // Irradiance by light that bins do not see.
    received: vec3<f32>,
}

// Irradiance.
struct LeafIrradiance {
    of_sky: vec3<f32>,
    // By the sky and by what emits.
    direct: vec3<f32>,
    // By all bounces so far.
    bounced: vec3<f32>,
    // What is reflected by the next bounce.
    last: vec3<f32>,
}
