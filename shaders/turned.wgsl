// Light of a turned environment on the tree of its samples, from the leaves up.

struct TurnedUniforms {
    // Columns of the grid, a power of two, and those by which its rows are shifted.
    columns: u32,
    shift: u32,
    // Weight of the next column.
    fraction: f32,
    samples_per_steradian: f32,
    // Scales radiance.
    intensity: f32,
    leaves: u32,
    // Spread of a leaf.
    leaf_spread: f32,
}

// Means over the leaves below a node.
struct Means {
    radiance: vec3<f32>,
    luminance_sq: f32,
    // Direction times luminance.
    weighted: vec3<f32>,
    luminance: f32,
}
