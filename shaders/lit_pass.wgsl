// Makes lit cuts: coarsens each stored cut under the light of the moment. Twin of core/src/cut/lit.rs. A first pass sums
// each vertex's light and counts the nodes; a second one writes them.

struct LitUniforms {
    // Number of stored cuts.
    cuts: u32,
    // Largest share of a vertex's light that a node moves between its parts.
    tau: f32,
}

@group(3) @binding(0) var<uniform> lit: LitUniforms;
// First texel of each stored cut.
@group(3) @binding(1) var<storage, read> starts: array<u32>;
@group(3) @binding(2) var<storage, read_write> written_offsets: array<u32>;
@group(3) @binding(3) var<storage, read_write> written_nodes: array<u32>;
// Number of nodes of all lit cuts.
@group(3) @binding(4) var<storage, read_write> total: atomic<u32>;
// Whole light of each cut.
@group(3) @binding(5) var<storage, read_write> whole_light: array<f32>;

// A node in the making.
struct Part {
    depth: u32,
    // Position of its first stored node in the stored cut.
    stored: u32,
    code: u32,
    value: f32,
    // Luminance times leaves.
    light: f32,
    // Light that its value moves between the stored nodes below it, at most.
    moved: f32,
}

// Parts that may still be joined: never two of one depth, once they were tried.
var<private> pending: array<Part, 17>;

@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let cut = cut_of(id, groups);
    if cut >= lit.cuts {
        return;
    }
    let start = starts[cut];
    whole_light[cut] = sum_of_light(start);
    let nodes = coarsen(start, whole_light[cut], false, 0u);
    written_offsets[start] = atomicAdd(&total, nodes);
}

@compute @workgroup_size(64)
fn write(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let cut = cut_of(id, groups);
    if cut >= lit.cuts {
        return;
    }
    let start = starts[cut];
    _ = coarsen(start, whole_light[cut], true, written_offsets[start]);
}

// The cut of an invocation. Workgroups lie in rows, because there is a limit to their number in each dimension.
fn cut_of(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.x + id.y * groups.x * 64u;
}

fn sum_of_light(start: u32) -> f32 {
    let leaves = 1u << tree_height();
    var cursor = visibility_cursor(start);
    var sum = 0.0;
    loop {
        let part = part_at(cursor, start);
        sum += part.light * part.value;
        if cursor.end >= leaves { break; }
        advance_visibility(&cursor);
    }
    return sum;
}

fn part_at(cursor: Cursor, start: u32) -> Part {
    let size = cursor_size(cursor.texel);
    let node = ((1u << tree_height()) + cursor.end - size) / size;
    let code = cursor.texel.x & 4095u;
    let light = luminance(nodes[node].radiance) * f32(size);
    return Part((cursor.texel.x >> 12u) & 15u, cursor.position - (start << 3u), code, value_of_code(code), light, 0.0);
}

// Coarsens a stored cut, and writes its nodes from `first` on if asked. Returns their number.
fn coarsen(start: u32, whole: f32, writes: bool, first: u32) -> u32 {
    let leaves = 1u << tree_height();
    var cursor = visibility_cursor(start);
    var done = 0u;
    var waiting = 0u;
    loop {
        pending[waiting] = part_at(cursor, start);
        waiting += 1u;
        while are_siblings(waiting, cursor.end) {
            let both = joined(pending[waiting - 2u], pending[waiting - 1u]);
            if lit.tau <= 0.0 || !(both.moved <= lit.tau * whole) {
                // No node to the left can be joined any more.
                done = flushed(waiting, writes, first, done);
                waiting = 0u;
                break;
            }
            waiting -= 1u;
            pending[waiting - 1u] = both;
        }
        if cursor.end >= leaves { break; }
        advance_visibility(&cursor);
    }
    return flushed(waiting, writes, first, done);
}

// Whether the last two of the waiting parts, which end at leaf `end`, have one parent.
fn are_siblings(waiting: u32, end: u32) -> bool {
    if waiting < 2u || pending[waiting - 2u].depth != pending[waiting - 1u].depth {
        return false;
    }
    let size = 1u << (tree_height() - pending[waiting - 1u].depth);
    return end % (2u * size) == 0u;
}

fn joined(left: Part, right: Part) -> Part {
    let light = left.light + right.light;
    let share = select(0.5, right.light / light, light > 0.0);
    let value = left.value + (right.value - left.value) * share;
    let moved = left.moved + left.light * abs(left.value - value) + right.moved + right.light * abs(right.value - value);
    let code = select(code_of_value(value), left.code, left.code == right.code);
    return Part(left.depth - 1u, left.stored, code, value, light, moved);
}

fn flushed(waiting: u32, writes: bool, first: u32, done: u32) -> u32 {
    if writes {
        for (var i = 0u; i < waiting; i += 1u) {
            let part = pending[i];
            written_nodes[first + done + i] = (part.stored << 16u) | (part.depth << 12u) | part.code;
        }
    }
    return done + waiting;
}

fn code_of_value(value: f32) -> u32 {
    if FIELD != FIELD_SOURCES {
        return u32(value / VALUE_SCALE + 0.5);
    }
    if !(value > LARGEST_SOLID_ANGLE * exp2(-ORDERS)) {
        return 0u;
    }
    return 1u + u32((log2(min(value / LARGEST_SOLID_ANGLE, 1.0)) + ORDERS) / ORDERS_PER_CODE + 0.5);
}
