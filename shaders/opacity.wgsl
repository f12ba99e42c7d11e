// Transparency of thin surfaces. Twin of core/src/opacity.rs and of the thresholds in render/src/shade/pixel_sampler.rs.

// Whether any surface transmits light; otherwise opacity is never read.
override HAS_VEILS: bool = false;

// Opacity and its cutoff follow the two parameters of emission.
const OPACITY: u32 = 2u;

// Share of light that a point blocks, from both sets of texture coordinates.
fn material_opacity(material: u32, uvs: vec4<f32>) -> f32 {
    let at = SurfaceAttributes(point_footprint(uvs.xy), point_footprint(uvs.zw), vec3(1.0));
    let first = materials[material].surface + OPACITY;
    let opacity = material_number(material, first, at, vec2(0.0, 1.0), 0.0);
    let cutoff = material_number(material, first + 1u, at, vec2(0.0, 1.0), 0.0);
    return select(opacity, select(0.0, 1.0, opacity >= cutoff), cutoff > 0.0);
}

// Mixes another word into a random seed.
fn mixed(hash: u32, word: u32) -> u32 {
    let state = (hash ^ word) * 747796405u + 2891336453u;
    let permuted = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (permuted >> 22u) ^ permuted;
}

// A random number in [0, 1).
fn chance(hash: u32) -> f32 {
    return f32(hash >> 8u) / 16777216.0;
}

// Samples of a pixel with evenly spread thresholds.
const STRATA: u32 = 16u;

// Opacity threshold above which a pixel sample sees a triangle.
fn threshold(pixel: vec2<u32>, sample: u32, triangle: u32) -> f32 {
    let of_pixel = mixed(mixed(0u, pixel.x), pixel.y);
    let seed = mixed(mixed(mixed(of_pixel, sample / STRATA), triangle), STRATA);
    let order = u32(chance(seed) * 4096.0);
    let stratum = (((sample % STRATA) ^ (order & 15u)) * (2u * ((order >> 4u) & 15u) + 1u) + (order >> 8u)) % STRATA;
    return (f32(stratum) + chance(mixed(mixed(of_pixel, sample), triangle))) / f32(STRATA);
}

// Whether a sample of a pixel passes a point of a triangle.
fn lets_through(triangle: u32, uvs: vec4<f32>, pixel: vec2<u32>, sample: u32) -> bool {
    if !HAS_VEILS {
        return false;
    }
    let opacity = material_opacity(triangles[triangle].material & ~TWO_SIDED, uvs);
    // A threshold may round to 1.
    return opacity < 1.0 && opacity <= threshold(pixel, sample, triangle);
}
