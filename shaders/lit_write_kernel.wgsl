// Writes the counted nodes of lit cuts.

// Total light of each cut.
@group(1) @binding(2) var<storage, read> whole_light: array<f32>;
@group(1) @binding(3) var<storage, read> offsets: array<u32>;
@group(1) @binding(4) var<storage, read_write> lit_nodes: array<u32>;

@compute @workgroup_size(64)
fn write(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cut = cut_of(group, lane);
    if cut >= lit.cuts {
        return;
    }
    let start = starts[cut];
    _ = coarsen(start, whole_light[cut], offsets[start]);
}

fn keep(index: u32, part: Part) {
    lit_nodes[index] = (part.stored << 16u) | (part.depth << 12u) | part.code;
}
