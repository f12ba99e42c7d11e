// Counts the nodes of lit cuts, and finds the start of each cut.

// Total light of each cut.
@group(1) @binding(2) var<storage, read_write> whole_light: array<f32>;
@group(1) @binding(3) var<storage, read_write> offsets: array<u32>;
// Number of nodes of all lit cuts.
@group(1) @binding(4) var<storage, read_write> total: atomic<u32>;

@compute @workgroup_size(64)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cut = cut_of(group, lane);
    if cut >= lit.cuts {
        return;
    }
    let start = starts[cut];
    whole_light[cut] = sum_of_light(start);
    let nodes = coarsen(start, whole_light[cut], 0u);
    offsets[start] = atomicAdd(&total, nodes);
}

// Nodes are only counted.
fn keep(index: u32, part: Part) {}

fn sum_of_light(start: u32) -> f32 {
    let leaves = 1u << tree_height();
    var cursor = visibility_cursor(start << 3u);
    var begin = 0u;
    var sum = 0.0;
    loop {
        let part = part_at(cursor, begin, start);
        sum += part.light * part.value;
        begin = end_of(cursor.node, begin);
        if begin >= leaves { break; }
        cursor = visibility_cursor(cursor.position + 1u);
    }
    return sum;
}
