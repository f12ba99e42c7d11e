// Unblocked directions from many origins, by following visibility boundaries: one workgroup for each origin. Twin of
// `BoundaryTracer::trace` in core/src/ray/boundaries: the groups that it traces do not depend on their order.
//
// Directions lie in groups of eight, groups in blocks. A probe of each block predicts its groups. Groups where predictions meet
// begin a queue; each traced group adds those that touch it and seem to differ, once each.

struct BoundaryUniforms {
    directions: u32,
    // Words of bits per origin; the number of rays follows them.
    words: u32,
    groups: u32,
    groups_per_block: u32,
    // Where parts of `tables` begin: the place of each block's probe is at 0.
    // The place of each direction of the caller's order.
    places: u32,
    // Where the list of each group begins, and the end of the last.
    starts: u32,
}

@group(1) @binding(0) var<uniform> rays: BoundaryUniforms;
// Group by group.
@group(1) @binding(1) var<storage, read> directions: array<vec4<f32>>;
// The last part are the lists: a touching group times 256, and the lanes of the own group with a neighbor in it.
@group(1) @binding(2) var<storage, read> tables: array<u32>;
@group(1) @binding(3) var<storage, read> origins: array<RayOrigin>;
// For each origin the states of its groups, and then its queue of as many groups.
@group(1) @binding(4) var<storage, read_write> states: array<atomic<u32>>;
@group(1) @binding(5) var<storage, read_write> open_words: array<u32>;

// Directions of a group.
const GROUP: u32 = 8u;

// A state: the wanted lanes of a group; above them those that a ray found open; and these bits.
const BLOCKED: u32 = 0x10000u;
const SEEN: u32 = 0x20000u;
const QUEUED: u32 = 0x40000u;
const WANTED: u32 = 0xffu;

const LANES: u32 = 64u;
// Groups that are traced at a time.
const AT_A_TIME: u32 = LANES / GROUP;

// Length of the queue.
var<workgroup> queued: atomic<u32>;
var<workgroup> end: u32;
var<workgroup> traced: atomic<u32>;
// Open lanes of the groups that are traced.
var<workgroup> found: array<atomic<u32>, AT_A_TIME>;

// Waits until all lanes have written what precedes.
fn all_lanes_meet() {
    storageBarrier();
    workgroupBarrier();
}

fn wanted_lanes(group: u32, at: RayOrigin) -> u32 {
    var lanes = 0u;
    for (var i = 0u; i < GROUP; i++) {
        let place = GROUP * group + i;
        if place < rays.directions && is_wanted(directions[place].xyz, at) {
            lanes |= 1u << i;
        }
    }
    return lanes;
}

// Traces the probe of a block, if it is wanted, and tells its groups.
fn probe(block: u32, first: u32, at: RayOrigin) {
    let place = tables[block];
    if !is_wanted(directions[place].xyz, at) {
        return;
    }
    let predicted = select(SEEN, BLOCKED, is_occluded(at.origin, directions[place].xyz));
    let group = block * rays.groups_per_block;
    for (var i = group; i < min(group + rays.groups_per_block, rays.groups); i++) {
        atomicOr(&states[first + i], predicted);
    }
    atomicAdd(&traced, 1u);
}

// Twin of `State::start`.
fn is_front(group: u32, first: u32) -> bool {
    let state = atomicLoad(&states[first + group]);
    if (state & WANTED) == 0u || (state & BLOCKED) != 0u {
        return false;
    }
    if (state & SEEN) == 0u {
        return true;
    }
    for (var i = tables[rays.starts + group]; i < tables[rays.starts + group + 1u]; i++) {
        let other = atomicLoad(&states[first + (tables[i] >> 8u)]);
        if (other & WANTED) != 0u && (other & SEEN) == 0u {
            return true;
        }
    }
    return false;
}

// Queues a group, unless it was.
fn enqueue(group: u32, first: u32) {
    if (atomicOr(&states[first + group], QUEUED) & QUEUED) == 0u {
        atomicStore(&states[first + rays.groups + atomicAdd(&queued, 1u)], group);
    }
}

// Queues the touching groups of a traced group that are expected to differ; each of its eight lanes takes some. Twin of
// `State::found`.
fn follow(group: u32, lane: u32, open: u32, first: u32) {
    let wanted = atomicLoad(&states[first + group]) & WANTED;
    for (var i = tables[rays.starts + group] + lane; i < tables[rays.starts + group + 1u]; i += GROUP) {
        let other = tables[i] >> 8u;
        let lanes = tables[i] & wanted;
        let state = atomicLoad(&states[first + other]);
        let is_darker = (state & SEEN) != 0u && (open & lanes) != lanes;
        let is_lighter = (state & BLOCKED) != 0u && (open & lanes) != 0u;
        if (is_darker || is_lighter) && (state & WANTED) != 0u {
            enqueue(other, first);
        }
    }
}

// Traces one direction of a queued group.
fn trace_lane(slot: u32, group: u32, lane: u32, first: u32, at: RayOrigin) {
    let wanted = atomicLoad(&states[first + group]) & WANTED;
    if ((wanted >> lane) & 1u) != 0u && !is_occluded(at.origin, directions[GROUP * group + lane].xyz) {
        atomicOr(&found[slot], 1u << lane);
    }
    if lane == 0u {
        atomicAdd(&traced, countOneBits(wanted));
    }
}

// Whether a direction, by its place, is open after all.
fn is_open(place: u32, first: u32) -> bool {
    let state = atomicLoad(&states[first + place / GROUP]);
    let open = select(select(0u, state, (state & SEEN) != 0u), state >> GROUP, (state & QUEUED) != 0u);
    return ((open >> (place % GROUP)) & 1u) != 0u;
}

// Bits of 32 directions in the caller's order.
fn word_of(word: u32, first: u32) -> u32 {
    var bits = 0u;
    for (var i = 32u * word; i < min(32u * word + 32u, rays.directions); i++) {
        if is_open(tables[rays.places + i], first) {
            bits |= 1u << (i % 32u);
        }
    }
    return bits;
}

@compute @workgroup_size(LANES)
fn trace(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = origins[id.y];
    let first = 2u * rays.groups * id.y;
    for (var group = lane; group < rays.groups; group += LANES) {
        atomicStore(&states[first + group], wanted_lanes(group, at));
    }
    all_lanes_meet();
    for (var block = lane; block * rays.groups_per_block < rays.groups; block += LANES) {
        probe(block, first, at);
    }
    all_lanes_meet();
    for (var group = lane; group < rays.groups; group += LANES) {
        if is_front(group, first) {
            enqueue(group, first);
        }
    }
    let slot = lane / GROUP;
    var head = 0u;
    // It ends, since a group is queued once.
    loop {
        all_lanes_meet();
        if lane == 0u {
            end = atomicLoad(&queued);
        }
        if lane < AT_A_TIME {
            atomicStore(&found[lane], 0u);
        }
        let last = workgroupUniformLoad(&end);
        if head == last {
            break;
        }
        let is_busy = head + slot < last;
        var group = 0u;
        if is_busy {
            group = atomicLoad(&states[first + rays.groups + head + slot]);
            trace_lane(slot, group, lane % GROUP, first, at);
        }
        workgroupBarrier();
        if is_busy {
            let open = atomicLoad(&found[slot]);
            if lane % GROUP == 0u {
                atomicOr(&states[first + group], open << GROUP);
            }
            follow(group, lane % GROUP, open, first);
        }
        head = min(head + AT_A_TIME, last);
    }
    let row = (rays.words + 1u) * id.y;
    for (var word = lane; word < rays.words; word += LANES) {
        open_words[row + word] = word_of(word, first);
    }
    if lane == 0u {
        open_words[row + rays.words] = atomicLoad(&traced);
    }
}
