// A receiver's decision on a node. Twin of core/src/implicit/direct/visit.rs, operation by operation.

// Sine of the least elevation of a visible node above the receiver, and of the receiver above the node.
const GRAZING: f32 = 1e-4;
// Squared sine below which a node counts as parallel to the receiver.
const PARALLEL: f32 = 1e-6;

const VISIT_SKIPS: u32 = 0u;
const VISIT_DESCENDS: u32 = 1u;
const VISIT_ENDS: u32 = 2u;

struct Receiver {
    position: vec3<f32>,
    // Tangents and normal.
    frame: mat3x3<f32>,
}

// `limit` is the largest integral of the cosine over a node, in steradians.
fn visit_of(node: ForestNode, is_inner: bool, receiver: Receiver, limit: f32) -> u32 {
    let normal = receiver.frame[2];
    let offset = node.center - receiver.position;
    let distance_sq = ordered_dot(offset, offset);
    let distance = sqrt(distance_sq);
    let grazing = distance * GRAZING;

    // Whether any part of it is in front of the receiver.
    let height = ordered_dot(offset, normal);
    let parallel = ordered_dot(normal, node.axis);
    let sine = sqrt(max((1.0 - PARALLEL) - parallel * parallel, 0.0));
    let top = height + node.radius * sine + node.thickness * abs(parallel);

    // Whether any part of it can face the receiver. All values are in units of the distance.
    let toward = -ordered_dot(offset, node.axis);
    let across = sqrt(max(distance_sq - toward * toward, 0.0));
    let facing = toward * node.cone_cos + (across + node.radius) * node.cone_sin + node.thickness;

    let projected = node.area * visible_share(node.coherence, toward, distance_sq);
    let is_large = projected * min(top, distance) > limit * distance_sq * distance_sq;
    let is_near = distance_sq < node.radius * node.radius;
    let is_under = height <= grazing;
    let counts = node.area > 0.0 && top > grazing && facing > grazing;
    let descends = counts && is_inner && (is_large || is_near || is_under);
    let ends = counts && !descends && !is_under;
    return select(select(VISIT_SKIPS, VISIT_ENDS, ends), VISIT_DESCENDS, descends);
}

// The visible area of a node as a share of its whole area, times the distance.
fn visible_share(coherence: f32, toward: f32, distance_sq: f32) -> f32 {
    let mean = coherence * toward;
    let spread = (1.0 - coherence * coherence) * 0.25 * distance_sq;
    return 0.5 * (mean + sqrt(mean * mean + spread));
}
