// Coarsens stored cuts under the current light, one invocation each. Twin of core/src/cut/lit.rs. One kernel sums each cut's light
// and counts its nodes; a second one writes them. Each defines `keep` for a finished node.

struct LitUniforms {
    // Number of stored cuts.
    cuts: u32,
    // Largest share of a vertex's light that a node may move between its parts.
    tau: f32,
    // Height of the tree below the cuts.
    tree_height: u32,
}

@group(1) @binding(0) var<uniform> lit: LitUniforms;
// First texel of each stored cut.
@group(1) @binding(1) var<storage, read> starts: array<u32>;

fn tree_height() -> u32 {
    return lit.tree_height;
}

// The cut of an invocation.
fn cut_of(group: vec3<u32>, lane: u32) -> u32 {
    return 64u * workgroup_number(group) + lane;
}

// A growing node.
struct Part {
    depth: u32,
    // Position of its first stored node in the stored cut.
    stored: u32,
    code: u32,
    value: f32,
    // Luminance times leaves.
    light: f32,
    // Upper bound of the light that its value moves between the stored nodes below it.
    moved: f32,
}

// Parts that may still be joined; never two of one depth after an attempt.
var<private> pending: array<Part, 17>;

fn part_at(cursor: Cursor, begin: u32, start: u32) -> Part {
    let size = leaves_below(cursor.node);
    let node = ((1u << tree_height()) + begin) / size;
    let code = cursor.node & 4095u;
    let light = luminance(nodes[node].radiance) * f32(size);
    return Part(node_depth(cursor.node), cursor.position - (start << 3u), code, value_of_code(code), light, 0.0);
}

// Coarsens a stored cut and keeps its nodes from `first` on, as the kernel defines. Returns their number.
fn coarsen(start: u32, whole: f32, first: u32) -> u32 {
    let leaves = 1u << tree_height();
    var cursor = visibility_cursor(start << 3u);
    var begin = 0u;
    var done = 0u;
    var waiting = 0u;
    loop {
        pending[waiting] = part_at(cursor, begin, start);
        waiting += 1u;
        let end = end_of(cursor.node, begin);
        while are_siblings(waiting, end) {
            let both = joined(pending[waiting - 2u], pending[waiting - 1u]);
            if lit.tau <= 0.0 || !(both.moved <= lit.tau * whole) {
                // No node to the left can still be joined.
                done = flushed(waiting, first, done);
                waiting = 0u;
                break;
            }
            waiting -= 1u;
            pending[waiting - 1u] = both;
        }
        if end >= leaves { break; }
        cursor = visibility_cursor(cursor.position + 1u);
        begin = end;
    }
    return flushed(waiting, first, done);
}

// Whether the last two waiting parts, which end at leaf `end`, have the same parent.
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

fn flushed(waiting: u32, first: u32, done: u32) -> u32 {
    for (var i = 0u; i < waiting; i += 1u) {
        keep(first + done + i, pending[i]);
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
