// Lit cuts: vertices' cuts coarsened under the current light by lit_write_kernel.wgsl. Twin of `PackedCursor` in
// core/src/cut/packed.rs.

// Nodes of all lit cuts: a packed node in the low half, the position of the first stored node below it in the high half.
@group(2) @binding(4) var<storage, read> lit_nodes: array<u32>;
// First lit node of the stored cut that starts at each texel.
@group(2) @binding(5) var<storage, read> lit_offsets: array<u32>;

fn lit_cursor(position: u32) -> Cursor {
    return Cursor(lit_nodes[position], position);
}

// The stored cut at `cut_offset` from a leaf on, by its lit cut, whose current node is the one around the leaf or, if that ends before
// leaf `next`, the one after it.
fn stored_below(lit: Cursor, cut_offset: u32, leaf: u32, next: u32) -> Cursor {
    var around = lit.node;
    if next < (1u << tree_height()) && begin_of(lit.node, next) > leaf {
        around = lit_nodes[lit.position - 1u];
    }
    var begin = begin_of(around, leaf);
    var stored = visibility_cursor((cut_offset << 3u) + (around >> 16u));
    while begin + leaves_below(stored.node) <= leaf {
        begin += leaves_below(stored.node);
        stored = visibility_cursor(stored.position + 1u);
    }
    return stored;
}
