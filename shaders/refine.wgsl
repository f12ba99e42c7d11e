// BRDF refinement: finds nodes of the merged cut that are too wide for the BRDF. Twin of render/src/shade/refine.rs.

// Off: the BRDF is sampled once per node, as in the paper (4.2).
override REFINE: bool = true;

const NARROWEST: f32 = 0.01;
const FINE: f32 = 0.7;
const NEGLIGIBLE: f32 = 0.02;
const WIDEST: f32 = 0.35;

// Whether a node of this radius is too wide for one cosine, from the cosine of its angle to the normal.
fn is_too_wide_for_a_cosine(to_normal: f32, radius: f32) -> bool {
    return REFINE && radius > WIDEST && to_normal > -radius;
}

// Whether a node of this radius and brightness needs several directions for one of the lobes, from the cosine of its angle to their
// peak. A width of 0 means no lobe.
fn is_too_wide(lobes: vec3<f32>, cos: f32, radius: f32, brightness: f32) -> bool {
    return is_too_wide_for(lobes.x, cos, radius, brightness)
        || is_too_wide_for(lobes.y, cos, radius, brightness)
        || is_too_wide_for(lobes.z, cos, radius, brightness);
}

fn is_too_wide_for(lobe: f32, cos: f32, radius: f32, brightness: f32) -> bool {
    if !(lobe > 0.0) || radius <= FINE * lobe {
        return false;
    }
    // Distances halve in the space of half vectors: the node is a disc of radius r / 2, whose variance along an axis widens the
    // lobe.
    let node_sq = 0.25 * radius * radius;
    let width_sq = lobe * lobe + 0.25 * node_sq;
    // The squared tangent of half the angle to the peak is (1 - cos) / (1 + cos).
    let near = 1.0 + cos;
    let far = width_sq * near + (1.0 - cos);
    return brightness * node_sq * width_sq * near * near > NEGLIGIBLE * far * far;
}
