// What a meshless function receives.

struct Coefficient {
    // Vector irradiance in W/m2, one column per color channel.
    vector: mat3x3<f32>,
}
