// Writes the counted nodes of cuts from bins.

// First texel of each cut.
@group(2) @binding(0) var<storage, read> starts: array<u32>;
@group(2) @binding(1) var<storage, read_write> texels: array<vec4<u32>>;

// Number of nodes of each invocation.
var<workgroup> found: array<u32, LANES>;
// Nodes of the cut, two in a word.
var<workgroup> nodes: array<atomic<u32>, MOST_DIRECTIONS / 2u>;

@compute @workgroup_size(64)
fn write(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = workgroup_number(group);
    select_cut(cut_vertices[number], lane);
    let range = directions_of(lane);
    found[lane] = nodes_within(range);
    workgroupBarrier();
    var place = 0u;
    var whole = 0u;
    for (var i = 0u; i < LANES; i += 1u) {
        place += select(0u, found[i], i < lane);
        whole += found[i];
    }
    for (var direction = range.x; direction < range.y;) {
        let node = node_over(direction);
        if first_of(node) == direction {
            atomicOr(&nodes[place / 2u], packed(node) << (16u * (place % 2u)));
            place += 1u;
        }
        direction = first_of(node) + (1u << size_log2(node));
    }
    workgroupBarrier();
    let first = starts[number] - cuts.first_texel;
    for (var texel = lane; 8u * texel < whole; texel += LANES) {
        var words = vec4(0u);
        for (var i = 0u; i < 4u; i += 1u) {
            words[i] = atomicLoad(&nodes[4u * texel + i]);
        }
        texels[first + texel] = words;
    }
}

// A node with the mean of its shares. Twin of `pack_node` in core/src/cut/packed.rs.
fn packed(node: u32) -> u32 {
    let size = 1u << size_log2(node);
    var sum = 0u;
    for (var direction = first_of(node); direction < first_of(node) + size; direction += 1u) {
        sum += share_at(direction);
    }
    return (firstLeadingBit(node) << 12u) | code_of(sum, size);
}
