// BRDF refinement: which nodes of the merged cut are too wide for the BRDF. Twin of render/src/shade/refine.rs.

// Off: the BRDF is sampled once per node, as in the paper (4.2).
override REFINE: bool = true;

const NARROWEST: f32 = 0.01;
const FINE: f32 = 0.7;
const NEGLIGIBLE: f32 = 0.02;
const WIDEST: f32 = 0.35;

// Whether a node of this radius, whose local direction is `wi`, should be halved; `lobe` is 0 without a lobe.
fn wants_halves(lobe: f32, radius: f32, tan_r: f32, wi: vec3<f32>, wo: vec3<f32>) -> bool {
    if radius > WIDEST {
        return wi.z > -radius;
    }
    if !(lobe > 0.0) || radius <= FINE * lobe {
        return false;
    }
    let half = wi + wo;
    // Tangent of the angle between normal and half vector, minus half of the node's radius: the best within the node.
    let tan_h = sqrt(half.x * half.x + half.y * half.y) / max(half.z, 1e-6);
    let t = max((tan_h - tan_r) / (1.0 + tan_h * tan_r), 0.0);
    let fall_off = 1.0 + t * t / (lobe * lobe);
    return min(radius / lobe, 4.0) > NEGLIGIBLE * fall_off * fall_off;
}
