// Values that a shader's own functions are too coarse or too slow for. See render/src/device/tables.rs.

struct Tables {
    // Linear values of the 256 sRGB codes.
    linear_from_srgb: array<vec4<f32>, 64>,
    // See Albedo in brdf.wgsl: two for each width of each lobe.
    albedo: array<vec4<f32>, 608>,
}
