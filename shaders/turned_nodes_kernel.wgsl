// The nodes of a tree of distant lights from means over their leaves. Twin of `NodeLight::distant` in core/src/light_tree/node_light.rs
// and of `NodeExtent::of_all` in render/src/light/node_row.rs.

@group(1) @binding(0) var<uniform> turned: TurnedUniforms;
@group(1) @binding(1) var<storage, read> means: array<Means>;
// Mean direction and radius of each node without light.
@group(1) @binding(2) var<storage, read> plain: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> nodes: array<Node>;
@group(1) @binding(4) var<storage, read_write> brightness: array<f32>;

const LARGEST: f32 = 3.4028235e38;

@compute @workgroup_size(64)
fn finish_nodes(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let node = 64u * workgroup_number(group) + lane;
    if node >= 2u * turned.leaves {
        return;
    }
    let mean = means[node];
    // Dark nodes contribute nothing; any direction inside them will do.
    var direction = plain[node].xyz;
    if mean.luminance > 0.0 {
        direction = mean.weighted / mean.luminance;
    }
    let place = ordered_normalize_or(direction, vec3(0.0, 1.0, 0.0));
    let spread = inv_kappa(ordered_length(direction)) + turned.leaf_spread;
    nodes[node] = Node(mean.radiance, spread, place, plain[node].w);
    brightness[node] = brightness_of(mean, luminance(means[1].radiance));
}

// Root mean square of the luminance relative to that of the whole tree, at least 1.
fn brightness_of(mean: Means, of_whole: f32) -> f32 {
    let ratio = sqrt(mean.luminance_sq) / of_whole;
    // Under no light it is no number.
    if !(of_whole > 0.0 && ratio > 1.0 && ratio <= LARGEST) {
        return 1.0;
    }
    return ratio;
}

// Of a mean resultant of a length.
fn inv_kappa(resultant: f32) -> f32 {
    let r = clamp(resultant, 1e-4, 1.0);
    return max((1.0 - r * r) / (r * (3.0 - r * r)), 0.0);
}
