// Visibility of leaves: the nearest node in each cell of the hemisphere, one workgroup per leaf. Twin of `Visits::find`,
// `cover::fill` and `Views::new` of core/src/implicit/. Bins and waiting blocks are in shared memory. The order of visits differs
// from the twin's, without effect: a bin keeps the least of the same keys.

const LANES: u32 = 64u;
const BLOCKS_AT_ONCE: u32 = 16u;
// Above this number, blocks are taken one at a time. The descent is then depth first, which adds at most three per level: with 48
// of the last sixteen and 20 levels, the waiting blocks always fit.
const NEARLY_FULL: u32 = 384u;
const MOST_WAITING: u32 = 512u;
// Nodes are entered 64 at a time, so that all invocations have work.
const MOST_ENDS: u32 = 2u * LANES;
// One empty neighbor in this many still makes a hole.
const AROUND_A_HOLE: u32 = 8u;

struct WalkUniforms {
    first_leaf: u32,
    // Number of blocks that hold the roots.
    root_blocks: u32,
    // The largest integral of the cosine over a node, in steradians.
    limit: f32,
    // Scale of distance codes, in 1/m2.
    scale: f32,
    // Cosine and sine of the frames' rotation.
    turn: vec2<f32>,
    // Whether the bins of a kept layer also count.
    has_kept: u32,
    // Whether to write nodes with closed holes instead of keys.
    closes: u32,
    // Cells along one edge of a leaf's square.
    side: u32,
    padding: u32,
}

// The workgroup's next step.
struct Step {
    blocks: u32,
    // Index of the first block in `waiting`, or the block's number for roots.
    first_block: u32,
    are_roots: u32,
    ends: u32,
    first_end: u32,
}

@group(1) @binding(0) var<uniform> walk: WalkUniforms;
@group(1) @binding(1) var<storage, read> discs: array<Disc>;
@group(1) @binding(2) var<storage, read> blocks: array<Block>;
// Directions of the cell centers, in a leaf's frame.
@group(1) @binding(3) var<storage, read> directions: array<vec4<f32>>;
// Whether to walk each object, one bit each.
@group(1) @binding(4) var<storage, read> walked: array<u32>;
@group(1) @binding(5) var<storage, read> kept: array<u32>;
@group(1) @binding(6) var<storage, read_write> seen: array<u32>;

var<workgroup> bins: array<atomic<u32>, MOST_CELLS>;
var<workgroup> waiting: array<u32, MOST_WAITING>;
var<workgroup> waiting_count: atomic<u32>;
var<workgroup> ends: array<u32, MOST_ENDS>;
var<workgroup> end_count: atomic<u32>;
var<workgroup> next_root: u32;
var<workgroup> planned: Step;

@compute @workgroup_size(64)
fn walk_forest(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let leaf = walk.first_leaf + workgroup_number(group);
    let cells = walk.side * walk.side;
    for (var cell = lane; cell < cells; cell += LANES) {
        atomicStore(&bins[cell], EMPTY);
    }
    let receiver = Receiver(discs[leaf].position, turned_frame(discs[leaf].normal, walk.turn));
    loop {
        workgroupBarrier();
        if lane == 0u {
            plan();
        }
        let step = workgroupUniformLoad(&planned);
        if step.blocks + step.ends == 0u {
            break;
        }
        let place = step.first_block + lane / CHILDREN;
        let block = select(waiting[min(place, MOST_WAITING - 1u)], place, step.are_roots != 0u);
        let end = ends[min(step.first_end + lane, MOST_ENDS - 1u)];
        workgroupBarrier();
        if lane / CHILDREN < step.blocks && is_walked(step, CHILDREN * block + lane % CHILDREN) {
            visit(block, lane % CHILDREN, receiver);
        }
        if lane < step.ends {
            enter(end, receiver);
        }
    }
    write_row(cells * leaf, lane);
}

// Takes waiting blocks, or roots, and the nodes to enter.
fn plan() {
    var step = Step();
    let waits = atomicLoad(&waiting_count);
    if waits > 0u {
        step.blocks = min(waits, select(BLOCKS_AT_ONCE, 1u, waits > NEARLY_FULL));
        step.first_block = waits - step.blocks;
        atomicStore(&waiting_count, step.first_block);
    } else {
        step.are_roots = 1u;
        step.blocks = min(BLOCKS_AT_ONCE, walk.root_blocks - next_root);
        step.first_block = next_root;
        next_root += step.blocks;
    }
    let found = atomicLoad(&end_count);
    if found >= LANES || step.blocks == 0u {
        step.ends = min(found, LANES);
        step.first_end = found - step.ends;
        atomicStore(&end_count, step.first_end);
    }
    planned = step;
}

// Whether a node belongs to no excluded object.
fn is_walked(step: Step, node: u32) -> bool {
    return step.are_roots == 0u || (walked[node / 32u] >> (node % 32u) & 1u) != 0u;
}

fn visit(block: u32, slot: u32, receiver: Receiver) {
    let below = blocks[block].below[slot];
    let kind = visit_of(node_in(block, slot), below != 0u, receiver, walk.limit);
    if kind == VISIT_DESCENDS {
        waiting[atomicAdd(&waiting_count, 1u)] = below;
    } else if kind == VISIT_ENDS {
        ends[atomicAdd(&end_count, 1u)] = CHILDREN * block + slot;
    }
}

fn node_in(block: u32, slot: u32) -> ForestNode {
    var node = ForestNode();
    for (var axis = 0u; axis < 3u; axis++) {
        node.center[axis] = blocks[block].center[axis][slot];
        node.axis[axis] = blocks[block].axis[axis][slot];
    }
    node.coherence = blocks[block].coherence[slot];
    node.area = blocks[block].area[slot];
    node.radius = blocks[block].radius[slot];
    node.thickness = blocks[block].thickness[slot];
    node.cone_cos = blocks[block].cone_cos[slot];
    node.cone_sin = blocks[block].cone_sin[slot];
    return node;
}

// Enters a node into the bins that it covers.
fn enter(node: u32, receiver: Receiver) {
    let disc = seen_disc(node_in(node / CHILDREN, node % CHILDREN), receiver, f32(walk.side));
    let key = distance_key(disc.distance_sq, node, walk.scale);
    for (var row = disc.first.y; row < disc.end.y; row++) {
        for (var column = disc.first.x; column < disc.end.x; column++) {
            let cell = row * walk.side + column;
            if meets(directions[cell].xyz, disc) {
                atomicMin(&bins[cell], key);
            }
        }
    }
}

// Writes the bins of a leaf, starting at `first`.
fn write_row(first: u32, lane: u32) {
    let cells = walk.side * walk.side;
    if walk.has_kept != 0u {
        for (var cell = lane; cell < cells; cell += LANES) {
            atomicMin(&bins[cell], kept[first + cell]);
        }
    }
    workgroupBarrier();
    for (var cell = lane; cell < cells; cell += LANES) {
        let key = atomicLoad(&bins[cell]);
        seen[first + cell] = select(key, closed(cell, key), walk.closes != 0u);
    }
}

// The node of a bin, for a hole the nearest of its neighbors. Twin of `closed` in core/src/implicit/views.rs.
fn closed(cell: u32, key: u32) -> u32 {
    if key != EMPTY {
        return node_of(key);
    }
    let place = vec2(cell % walk.side, cell / walk.side);
    let low = max(place, vec2(1u)) - 1u;
    let high = min(place + 1u, vec2(walk.side - 1u));
    var nearest = EMPTY;
    var open = 0u;
    var all = 0u;
    for (var row = low.y; row <= high.y; row++) {
        for (var column = low.x; column <= high.x; column++) {
            let near = atomicLoad(&bins[row * walk.side + column]);
            nearest = min(nearest, near);
            open += select(0u, 1u, near == EMPTY);
            all += 1u;
        }
    }
    // Excludes the bin itself, which is open.
    let is_hole = open - 1u <= (all - 1u) / AROUND_A_HOLE;
    return select(EMPTY, node_of(nearest), is_hole);
}
