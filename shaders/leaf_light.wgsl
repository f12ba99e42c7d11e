// Light sources of a forest's leaves, and the leaves' light. Twin of `Lighting` and `LeafLight` in core/src/implicit/gather.rs.

const FRAC_1_PI: f32 = 0.318309886;

struct LightUniforms {
    // Cosine and sine of the frames' rotation.
    turn: vec2<f32>,
    // What leaves send, as the constants below tell. With emission the sky is gathered, too.
    sends: u32,
    // Cells along one edge of a leaf's square.
    side: u32,
}

// The light of the last bounce; what they emit; all that a picture shows of them.
const SENDS_LAST: u32 = 0u;
const SENDS_EMISSION: u32 = 1u;
const SENDS_ALL: u32 = 2u;

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
