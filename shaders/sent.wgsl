// Light that the nodes of a tree of sources send by direction, over what the brightest channel of diffuse ones would send, at knots
// over an octahedron unfolded to a square.
// Twin of render/src/light/sent.rs.

// Whether nodes do.
override BY_DIRECTION: bool = false;

// Knots of the nodes, node by node.
@group(2) @binding(6) var sent: texture_2d<f32>;

// Knots along an edge of a node's square.
const SENT_SIDE: u32 = 16u;
// Nodes in a row of squares.
const SENT_COLUMNS: u32 = 256u;

// Mean radiance of a node, or what it sends back along the unit direction that leads to it.
fn radiance_along(node: u32, direction: vec3<f32>) -> vec3<f32> {
    let mean = nodes[node].radiance;
    if !BY_DIRECTION {
        return mean;
    }
    let toward = sent_share(node, -direction) * max(max(mean.x, mean.y), mean.z);
    // The view of gloss shows what it adds to diffuse sources.
    return select(toward, toward - mean, frame.view_mode == VIEW_GLOSS);
}

fn sent_share(node: u32, direction: vec3<f32>) -> vec3<f32> {
    let place = octahedron_place(direction) * f32(SENT_SIDE - 1u);
    let knot = clamp(floor(place), vec2(0.0), vec2(f32(SENT_SIDE - 2u)));
    let share = place - knot;
    let first = vec2(node % SENT_COLUMNS, node / SENT_COLUMNS) * SENT_SIDE + vec2<u32>(knot);
    let upper = mix(textureLoad(sent, first, 0).xyz, textureLoad(sent, first + vec2(1u, 0u), 0).xyz, share.x);
    let lower = mix(textureLoad(sent, first + vec2(0u, 1u), 0).xyz, textureLoad(sent, first + vec2(1u), 0).xyz, share.x);
    return mix(upper, lower, share.y);
}
