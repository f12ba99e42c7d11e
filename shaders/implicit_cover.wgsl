// The cells of a receiver covered by a node. Twin of core/src/implicit/direct/cover.rs, operation by operation.

// Radius of a disc in radii of a circle of its area.
const OVERLAP: f32 = 1.175;
// The largest slope of the concentric map.
const STEEPEST_MAP: f32 = 0.5 * 1.62;
// Sine of the angle between center and edge of a disc up to which CHORD holds.
const WIDE: f32 = 0.7;
// Largest ratio of the distance between the directions of center and edge to that sine.
const CHORD: f32 = 1.09;
const FRAC_2_PI: f32 = 0.636619772;

// A disc in the frame of a receiver.
struct SeenDisc {
    // Center in meters.
    offset: vec3<f32>,
    // Normal over its product with the offset; zero for a disc that faces away.
    plane: vec3<f32>,
    // Squared distance minus squared radius.
    excess: f32,
    distance_sq: f32,
    // Range of cells that it may cover: the first column and row, and one past the last.
    first: vec2<u32>,
    end: vec2<u32>,
}

fn seen_disc(node: ForestNode, receiver: Receiver, side: f32) -> SeenDisc {
    var disc = SeenDisc();
    disc.offset = frame_from_world(receiver.frame, node.center - receiver.position);
    let axis = frame_from_world(receiver.frame, node.axis);
    disc.distance_sq = ordered_dot(disc.offset, disc.offset);
    let inverse = 1.0 / sqrt(disc.distance_sq);
    let direction = disc.offset * inverse;
    let share = visible_share(node.coherence, -ordered_dot(axis, direction), 1.0);

    let tilted = axis * node.coherence - direction * (1.0 - node.coherence);
    let normal = tilted * (1.0 / sqrt(ordered_dot(tilted, tilted)));
    let cosine = -ordered_dot(normal, direction);
    disc.plane = normal * select(0.0, -inverse / cosine, cosine > GRAZING);
    let area = node.area * min(share / max(cosine, GRAZING), 1.0);
    let radius_sq = (OVERLAP * OVERLAP / PI) * area;
    disc.excess = disc.distance_sq - radius_sq;

    let sine = sqrt(radius_sq) * inverse;
    let reach = select(2.0 * side, sine * (CHORD * STEEPEST_MAP * side), sine < WIDE);
    let place = cell_coordinates(direction.xy, side);
    disc.first = cell_at(place - reach + 0.5, side);
    disc.end = cell_at(place + reach + 0.5, side);
    return disc;
}

// Whether the ray through a cell's center hits a disc.
fn meets(direction: vec3<f32>, disc: SeenDisc) -> bool {
    let nearness = ordered_dot(direction, disc.plane);
    let gap = 1.0 + nearness * (nearness * disc.excess - 2.0 * ordered_dot(direction, disc.offset));
    return nearness > 0.0 && gap <= 0.0;
}

fn cell_at(place: vec2<f32>, side: f32) -> vec2<u32> {
    return vec2<u32>(clamp(place, vec2(0.0), vec2(side)));
}

// Square coordinates in cells of a point in the unit disc (Shirley and Chiu 1997), to 2e-3 of a cell.
fn cell_coordinates(p: vec2<f32>, side: f32) -> vec2<f32> {
    let size = abs(p);
    let t = min(size.x, size.y) / max(max(size.x, size.y), 1.1754944e-38);
    let t_sq = t * t;
    // Abramowitz and Stegun, 4.4.47.
    let series = ((0.0208351 * t_sq - 0.0851330) * t_sq + 0.1801410) * t_sq - 0.3302995;
    let angle = (series * t_sq + 0.9998660) * t;
    let radius = sqrt(p.x * p.x + p.y * p.y);
    let turn = radius * (2.0 * FRAC_2_PI) * angle;
    let place = select(vec2(radius, turn), vec2(turn, radius), size.y > size.x);
    let half = 0.5 * side;
    return half + half * select(place, -place, p < vec2(0.0));
}
