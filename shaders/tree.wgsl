// A tree of lights by heap index, and its nodes seen from a point. Twin of render/src/shade/node_field.rs,
// core/src/light_tree/node_light.rs and core/src/sources/light.rs.

// Kind of tree: none, distant lights of the environment, or surface sources.
override FIELD: u32 = 1u;

const FIELD_NONE: u32 = 0u;
const FIELD_ENVIRONMENT: u32 = 1u;
const FIELD_SOURCES: u32 = 2u;

@group(2) @binding(0) var<storage, read> nodes: array<Node>;
// Brightness of each node relative to the mean of the whole tree; at least 1.
@group(2) @binding(1) var<storage, read> brightness: array<f32>;

// Least distance in meters.
const LEAST_DISTANCE: f32 = 1e-6;

// Directions of a node.
struct Cone {
    // Unit direction to the node.
    direction: vec3<f32>,
    // Half-angle in radians.
    radius: f32,
    // Spread of the light as an inverse concentration.
    inv_kappa: f32,
}

fn cone_of(node: u32, origin: vec3<f32>) -> Cone {
    let n = nodes[node];
    if FIELD != FIELD_SOURCES {
        return Cone(n.place, n.radius, n.spread);
    }
    let to_center = n.place - origin;
    let distance = max(length(to_center), LEAST_DISTANCE);
    let t = n.radius / distance;
    let radius = 2.0 * t / (1.0 + sqrt(1.0 + t * t));
    // A cap of half-angle r, tan r = spread / distance, has its centroid at R = (1 + cos r) / 2.
    let s = n.spread / distance;
    let resultant = 0.5 + 0.5 / sqrt(1.0 + s * s);
    let inv_kappa = (1.0 - resultant * resultant) / (resultant * (3.0 - resultant * resultant));
    return Cone(to_center / distance, radius, inv_kappa);
}
