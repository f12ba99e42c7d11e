// Visibility cuts of vertices from the bins of the leaves beside them, one workgroup each. Twin of `of_bins` in
// render/src/light/implicit/cuts.rs and of `CutSelector` in core/src/cut/visibility.rs. One kernel counts the nodes of the cuts; a
// second one writes them.

const LANES: u32 = 64u;
const MOST_DIRECTIONS: u32 = 2048u;
// Share of the sky in a direction where all leaves that face it see the sky.
const FULL_SHARE: u32 = 255u;
const LARGEST_CODE: f32 = 4095.0;
// Of `square_from_disc` in core/src/sphere/concentric.rs (Abramowitz and Stegun, 4.4.49).
const ARCTANGENT: array<f32, 8> = array(
    0.0028662257, -0.0161657367, 0.0429096138, -0.0752896400, 0.1065626393, -0.1420889944, 0.1999355085, -0.3333314528
);
const FRAC_2_PI: f32 = 0.636619772;

struct CutUniforms {
    // The least squared error from which a node is split, by its depth: times its directions and FULL_SHARE squared, as low and high
    // word.
    least: array<vec4<u32>, 12>,
    // Cosine and sine of the frames' rotation.
    turn: vec2<f32>,
    // Cells along one edge of a leaf's square.
    side: u32,
    // Height of the tree over the directions.
    height: u32,
    // First texel of the cuts.
    first_texel: u32,
    padding: u32,
    more_padding: vec2<u32>,
}

@group(1) @binding(0) var<uniform> cuts: CutUniforms;
@group(1) @binding(1) var<storage, read> discs: array<Disc>;
// Visible node in each cell of each leaf.
@group(1) @binding(2) var<storage, read> views: array<u32>;
// Directions at the leaves of the tree.
@group(1) @binding(3) var<storage, read> directions: array<vec4<f32>>;
@group(1) @binding(4) var<storage, read> beside: array<LeafBeside>;
// Open share of each leaf.
@group(1) @binding(5) var<storage, read> open: array<f32>;
@group(1) @binding(6) var<storage, read> cut_vertices: array<CutVertex>;

// Shares of the sky, four in a word.
var<workgroup> shares: array<u32, MOST_DIRECTIONS / 4u>;
// Sums of the shares below a node, and of their products with what they lack of FULL_SHARE, at its first pair of directions.
var<workgroup> sums: array<vec2<u32>, MOST_DIRECTIONS / 2u>;
// Whether a node is split, one bit each.
var<workgroup> split: array<atomic<u32>, MOST_DIRECTIONS / 32u>;

fn select_cut(vertex: CutVertex, lane: u32) {
    let count = 1u << cuts.height;
    for (var word = lane; word < count / 4u; word += LANES) {
        var packed = 0u;
        for (var i = 0u; i < 4u; i += 1u) {
            packed |= share_of_sky(directions[4u * word + i].xyz, vertex) << (8u * i);
        }
        shares[word] = packed;
    }
    for (var word = lane; word < MOST_DIRECTIONS / 32u; word += LANES) {
        atomicStore(&split[word], 0u);
    }
    workgroupBarrier();
    for (var pair = lane; pair < count / 2u; pair += LANES) {
        let a = share_at(2u * pair);
        let b = share_at(2u * pair + 1u);
        let halves = array(vec2(a, a * (FULL_SHARE - a)), vec2(b, b * (FULL_SHARE - b)));
        split_if_coarse(count / 2u + pair, halves);
        sums[pair] = halves[0] + halves[1];
    }
    for (var depth = cuts.height - 1u; depth > 0u; depth -= 1u) {
        workgroupBarrier();
        let nodes = 1u << (depth - 1u);
        let pairs = (count / 2u) / nodes;
        for (var i = lane; i < nodes; i += LANES) {
            let halves = array(sums[pairs * i], sums[pairs * i + pairs / 2u]);
            split_if_coarse(nodes + i, halves);
            sums[pairs * i] = halves[0] + halves[1];
        }
    }
    workgroupBarrier();
}

// Of the leaves that face the direction.
fn share_of_sky(direction: vec3<f32>, vertex: CutVertex) -> u32 {
    var sky = 0.0;
    var above = 0.0;
    for (var i = vertex.first; i < vertex.end; i += 1u) {
        let leaf = beside[i].leaf;
        let local = frame_from_world(turned_frame(discs[leaf].normal, cuts.turn), direction);
        if local.z > 0.0 {
            let weight = beside[i].weight * select(open[leaf], 1.0, (vertex.number & MOVED) != 0u);
            above += weight;
            if views[cuts.side * cuts.side * leaf + cell_of(local)] == EMPTY {
                sky += weight;
            }
        }
    }
    return select(0u, u32(sky / above * f32(FULL_SHARE) + 0.5), above > 0.0);
}

// Twin of `HemisphereCells::cell_of`.
fn cell_of(direction: vec3<f32>) -> u32 {
    let size = abs(direction.xy);
    let is_wide = size.x >= size.y;
    let long = select(size.y, size.x, is_wide);
    let t = select(0.0, select(size.x, size.y, is_wide) / long, long > 0.0);
    let t_sq = t * t;
    var series = 0.0;
    for (var i = 0u; i < 8u; i += 1u) {
        series = series * t_sq + ARCTANGENT[i];
    }
    let radius = sqrt(size.x * size.x + size.y * size.y);
    let turn = radius * 2.0 * FRAC_2_PI * (t + t * t_sq * series);
    let place = select(vec2(turn, radius), vec2(radius, turn), is_wide);
    let square = 0.5 + 0.5 * select(place, -place, direction.xy < vec2(0.0));
    let cell = min(vec2<u32>(square * f32(cuts.side)), vec2(cuts.side - 1u));
    return cell.y * cuts.side + cell.x;
}

fn share_at(direction: u32) -> u32 {
    return (shares[direction / 4u] >> (8u * (direction % 4u))) & 255u;
}

// The squared error is taken in whole numbers, so that it decides as the twin does. Halves that are stored as equal nodes are one.
fn split_if_coarse(node: u32, halves: array<vec2<u32>, 2>) {
    let depth = firstLeadingBit(node);
    let log2_size = cuts.height - depth;
    let moments = halves[0] + halves[1];
    let half_size = 1u << (log2_size - 1u);
    let are_whole = !is_split(2u * node) && !is_split(2u * node + 1u);
    if are_whole && code_of(halves[0].x, half_size) == code_of(halves[1].x, half_size) {
        return;
    }
    let squares = moments.x * FULL_SHARE - moments.y;
    let scaled = vec2(squares << log2_size, squares >> (32u - log2_size));
    let error = wide_difference(scaled, wide_square(moments.x));
    let least = cuts.least[depth].xy;
    if error.y > least.y || error.y == least.y && error.x >= least.x {
        atomicOr(&split[node / 32u], 1u << (node % 32u));
    }
}

// The square of a number below 2^20, as low word and high word.
fn wide_square(a: u32) -> vec2<u32> {
    let upper = a >> 10u;
    let lower = a & 1023u;
    let rest = ((2u * upper * lower) << 10u) + lower * lower;
    let low = ((upper * upper) << 20u) + rest;
    return vec2(low, ((upper * upper) >> 12u) + select(0u, 1u, low < rest));
}

fn wide_difference(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

// The node of the selected cut over a direction, by heap index.
fn node_over(direction: u32) -> u32 {
    var node = 1u;
    for (var height = cuts.height; height > 0u && is_split(node); height -= 1u) {
        node = 2u * node + ((direction >> (height - 1u)) & 1u);
    }
    return node;
}

// The leaves of the tree are not.
fn is_split(node: u32) -> bool {
    if node >= (1u << cuts.height) {
        return false;
    }
    return ((atomicLoad(&split[node / 32u]) >> (node % 32u)) & 1u) != 0u;
}

// The mean of shares as it is stored. Twin of `quantize` in core/src/cut/packed.rs.
fn code_of(sum: u32, size: u32) -> u32 {
    return u32(f32(sum) / f32(FULL_SHARE * size) * LARGEST_CODE + 0.5);
}

// Its first direction.
fn first_of(node: u32) -> u32 {
    return (node << size_log2(node)) - (1u << cuts.height);
}

fn size_log2(node: u32) -> u32 {
    return cuts.height - firstLeadingBit(node);
}

// The directions that an invocation looks at: those from `x` to before `y`.
fn directions_of(lane: u32) -> vec2<u32> {
    let count = 1u << cuts.height;
    let each = max(count / LANES, 1u);
    return min(vec2(lane, lane + 1u) * each, vec2(count));
}

// The number of nodes that begin at some directions.
fn nodes_within(range: vec2<u32>) -> u32 {
    var number = 0u;
    for (var direction = range.x; direction < range.y;) {
        let node = node_over(direction);
        number += select(0u, 1u, first_of(node) == direction);
        direction = first_of(node) + (1u << size_log2(node));
    }
    return number;
}
