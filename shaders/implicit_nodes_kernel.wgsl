// Computes nodes from the discs below them, one workgroup per node. Equals its twin `Node::around` in
// core/src/implicit/forest/nodes.rs bit for bit: seven invocations sum one number each, disc by disc, and all search for the
// farthest disc, where order does not matter. All nodes are computed directly from the leaves, so none waits for another.

const LANES: u32 = 64u;
// Sums of area, position times area, and normal times area.
const SUMS: u32 = 7u;

@group(1) @binding(0) var<storage, read> discs: array<Disc>;
// The first leaf below each node, and one past the last.
@group(1) @binding(1) var<storage, read> spans: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read_write> blocks: array<Block>;

var<workgroup> addends: array<array<f32, LANES>, SUMS>;
var<workgroup> sums: array<f32, SUMS>;
// Radius, thickness, and least cosine of a normal.
var<workgroup> reaches: array<vec3<f32>, LANES>;

@compute @workgroup_size(64)
fn make_nodes(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = workgroup_number(group);
    let span = spans[number];
    for (var first = span.x; first < span.y; first += LANES) {
        add_some(first, span.y, lane);
    }
    workgroupBarrier();
    let node = node_of_sums(span.x);
    reaches[lane] = reach_of_some(node, span, lane);
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            reaches[lane] = joined(reaches[lane], reaches[lane + half]);
        }
    }
    if lane == 0u {
        write(number, with_reach(node, reaches[0]));
    }
}

// Adds up to 64 discs, starting at `first`, to the sums.
fn add_some(first: u32, end: u32, lane: u32) {
    if first + lane < end {
        let disc = discs[first + lane];
        let position = disc.position * disc.area;
        let normal = disc.normal * disc.area;
        addends[0][lane] = disc.area;
        for (var axis = 0u; axis < 3u; axis++) {
            addends[1u + axis][lane] = position[axis];
            addends[4u + axis][lane] = normal[axis];
        }
    }
    workgroupBarrier();
    if lane < SUMS {
        for (var i = 0u; i < min(LANES, end - first); i++) {
            sums[lane] += addends[lane][i];
        }
    }
    workgroupBarrier();
}

// The node without its order-independent values. `first` is its first leaf.
fn node_of_sums(first: u32) -> ForestNode {
    var node = ForestNode();
    if sums[0] > 0.0 {
        node.area = sums[0];
        node.center = vec3(sums[1], sums[2], sums[3]) / node.area;
        let mean = vec3(sums[4], sums[5], sums[6]) / node.area;
        node.axis = ordered_normalize_or(mean, discs[first].normal);
        node.coherence = min(ordered_length(mean), 1.0);
    }
    return node;
}

// Reach over every 64th disc.
fn reach_of_some(node: ForestNode, span: vec2<u32>, lane: u32) -> vec3<f32> {
    var reach = vec3(0.0, 0.0, 1.0);
    for (var leaf = span.x + lane; leaf < span.y; leaf += LANES) {
        let offset = discs[leaf].position - node.center;
        let radius = disc_radius(discs[leaf].area);
        let cosine = ordered_dot(discs[leaf].normal, node.axis);
        let height = abs(ordered_dot(offset, node.axis)) + radius * sine(cosine);
        reach = joined(reach, vec3(ordered_length(offset) + radius, height, cosine));
    }
    return reach;
}

fn joined(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3(max(a.x, b.x), max(a.y, b.y), min(a.z, b.z));
}

fn with_reach(node: ForestNode, reach: vec3<f32>) -> ForestNode {
    var whole = node;
    if node.area > 0.0 {
        whole.radius = reach.x;
        whole.thickness = reach.y;
        let cone_sin = sine(reach.z);
        let cone = select(vec2(reach.z, cone_sin), vec2(1.0, 0.0), cone_sin == 0.0);
        let is_wide = !(reach.z > 0.0);
        whole.cone_cos = select(cone.x, 0.0, is_wide);
        whole.cone_sin = select(cone.y, 1.0, is_wide);
    }
    return whole;
}

fn write(number: u32, node: ForestNode) {
    let block = number / CHILDREN;
    let slot = number % CHILDREN;
    for (var axis = 0u; axis < 3u; axis++) {
        blocks[block].center[axis][slot] = node.center[axis];
        blocks[block].axis[axis][slot] = node.axis[axis];
    }
    blocks[block].coherence[slot] = node.coherence;
    blocks[block].area[slot] = node.area;
    blocks[block].radius[slot] = node.radius;
    blocks[block].thickness[slot] = node.thickness;
    blocks[block].cone_cos[slot] = node.cone_cos;
    blocks[block].cone_sin[slot] = node.cone_sin;
}
