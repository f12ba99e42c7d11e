// Quadtrees of discs (implicit visibility, 4.1). Twin of core/src/implicit/forest/nodes.rs.

const CHILDREN: u32 = 4u;
// Squared sine below which directions count as equal.
const FLAT: f32 = 1e-6;
const PI: f32 = 3.14159265;

struct Disc {
    position: vec3<f32>,
    area: f32,
    normal: vec3<f32>,
    padding: u32,
}

// Four adjacent nodes.
struct Block {
    center: array<vec4<f32>, 3>,
    axis: array<vec4<f32>, 3>,
    coherence: vec4<f32>,
    area: vec4<f32>,
    radius: vec4<f32>,
    thickness: vec4<f32>,
    cone_cos: vec4<f32>,
    cone_sin: vec4<f32>,
    // The blocks with each node's children; 0 for leaves and empty slots.
    below: vec4<u32>,
}

// See core/src/implicit/forest/nodes.rs for units.
struct ForestNode {
    center: vec3<f32>,
    axis: vec3<f32>,
    coherence: f32,
    area: f32,
    radius: f32,
    thickness: f32,
    cone_cos: f32,
    cone_sin: f32,
}

fn disc_radius(area: f32) -> f32 {
    return sqrt(area / PI);
}

fn sine(cosine: f32) -> f32 {
    let sine_sq = 1.0 - cosine * cosine;
    return select(0.0, sqrt(sine_sq), sine_sq > FLAT);
}
