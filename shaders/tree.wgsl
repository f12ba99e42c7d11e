// The light tree under the current light, by heap index. Twin of core/src/light_tree/lighting.rs.

struct Node {
    // Mean radiance.
    radiance: vec3<f32>,
    // Inverse concentration as a von Mises-Fisher lobe.
    inv_kappa: f32,
    // Unit direction, weighted by radiance.
    direction: vec3<f32>,
    // Half-angle in radians of the cone of its leaves.
    radius: f32,
}

@group(2) @binding(0) var<storage, read> nodes: array<Node>;
// Tangent of half of each node's radius.
@group(2) @binding(1) var<storage, read> tan_half_radius: array<f32>;
