// What a leaf adds to the vertices beside it, before the weight that each gives it.
struct LeafValue {
    // Irradiance from the sky, times the weight.
    sky: vec3<f32>,
    // Open share, 0 to 1.
    open: f32,
    // Irradiance from other leaves, times the weight.
    others: vec3<f32>,
    // The open share; beside gloss times the albedo.
    weight: vec3<f32>,
}
