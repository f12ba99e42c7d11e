// Counts the nodes of cuts from bins, and finds the place of each cut.

// First texel of each cut.
@group(2) @binding(0) var<storage, read_write> starts: array<u32>;
// The first texel after all cuts so far; then the number of nodes of each cut.
@group(2) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;

const NODES_PER_TEXEL: u32 = 8u;

var<workgroup> found: atomic<u32>;

@compute @workgroup_size(64)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = workgroup_number(group);
    select_cut(cut_vertices[number], lane);
    atomicAdd(&found, nodes_within(directions_of(lane)));
    workgroupBarrier();
    if lane == 0u {
        let nodes = atomicLoad(&found);
        starts[number] = atomicAdd(&counts[0], (nodes + NODES_PER_TEXEL - 1u) / NODES_PER_TEXEL);
        atomicStore(&counts[number + 1u], nodes);
    }
}
