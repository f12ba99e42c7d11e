// Lit cuts: vertices' cuts coarsened under the current light by lit_write_kernel.wgsl. Twin of `PackedCursor` in
// core/src/cut/packed.rs.

// Nodes of all lit cuts: a packed node in the low half, the position of the first stored node below it in the high half.
@group(2) @binding(4) var<storage, read> lit_nodes: array<u32>;
// First lit node of the stored cut that starts at each texel.
@group(2) @binding(5) var<storage, read> lit_offsets: array<u32>;

fn lit_cursor(cut_offset: u32) -> Cursor {
    let position = lit_offsets[cut_offset];
    return cursor_at(lit_nodes[position], position, 0u);
}

fn advance_lit(cursor: ptr<function, Cursor>) {
    let position = (*cursor).position + 1u;
    *cursor = cursor_at(lit_nodes[position], position, (*cursor).end);
}

// At the node that contains `leaf`: the current one or that before it.
fn lit_around(lit: Cursor, leaf: u32) -> Cursor {
    let begin = lit.end - leaves_below(lit.node);
    if leaf >= begin {
        return lit;
    }
    return Cursor(lit_nodes[lit.position - 1u], lit.position - 1u, begin);
}

// Advances a position in the stored cut at `cut_offset` to the node that contains `leaf`, which lies below the current node of `lit` or
// that before it.
fn seek_visibility(cursor: ptr<function, Cursor>, cut_offset: u32, lit: Cursor, leaf: u32) {
    let around = lit_around(lit, leaf);
    let position = (cut_offset << 3u) + (around.node >> 16u);
    if position > (*cursor).position {
        *cursor = cursor_at(visibility_node(position), position, around.end - leaves_below(around.node));
    }
    while (*cursor).end <= leaf {
        advance_visibility(cursor);
    }
}
