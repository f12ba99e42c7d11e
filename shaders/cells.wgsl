// The hemisphere in cells of equal cosine weight, and the BRDF over them. Twin of core/src/sphere/concentric.rs.

// See LEAST_COSINE in render/src/light/bounce/wavelet.rs.
const LEAST_CELL_COSINE: f32 = 1e-4;

// Twin of `HemisphereCells::direction_of`.
fn direction_of(cell: u32, side: u32) -> vec3<f32> {
    let center = (vec2(f32(cell % side), f32(cell / side)) + 0.5) / f32(side);
    let disc = concentric(2.0 * center - 1.0);
    return vec3(disc, sqrt(max(1.0 - dot(disc, disc), 0.0)));
}

// The BRDF for a cell in a local direction, with this integral of the cosine.
fn cell_brdf(point: SurfacePoint, wi: vec3<f32>, weight: f32) -> vec3<f32> {
    let cos = max(wi.z, LEAST_CELL_COSINE);
    let spread = weight * FRAC_1_PI / (4.0 * cos);
    return brdf_cos(point.brdf, wi, point.wo, spread, point.slopes) / cos;
}
