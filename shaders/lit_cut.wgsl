// Lit cuts: vertices' cuts coarsened under the current light by lit_write_kernel.wgsl. Twin of `PackedCursor` in
// core/src/cut/packed.rs.

// Nodes of all lit cuts: a packed node in the low half, the position of the first stored node below it in the high half.
@group(2) @binding(4) var<storage, read> lit_nodes: array<u32>;
// First lit node of the stored cut that starts at each texel.
@group(2) @binding(5) var<storage, read> lit_offsets: array<u32>;

// A position in a lit cut.
struct LitCursor {
    node: u32,
    // Index of the node in the whole array.
    position: u32,
    // One past the last leaf of the node.
    end: u32,
}

// Leaves below a packed node.
fn lit_size(node: u32) -> u32 {
    return 1u << (tree_height() - ((node >> 12u) & 15u));
}

fn lit_cursor(cut_offset: u32) -> LitCursor {
    let position = lit_offsets[cut_offset];
    let node = lit_nodes[position];
    return LitCursor(node, position, lit_size(node));
}

fn lit_value(cursor: LitCursor) -> f32 {
    return value_of_code(cursor.node & 4095u);
}

fn advance_lit(cursor: ptr<function, LitCursor>) {
    (*cursor).position += 1u;
    (*cursor).node = lit_nodes[(*cursor).position];
    (*cursor).end += lit_size((*cursor).node);
}

// Advances a position in the stored cut at `cut_offset` to the node that contains `leaf`, which lies below the node of `lit`.
fn seek_visibility(cursor: ptr<function, Cursor>, cut_offset: u32, lit: LitCursor, leaf: u32) {
    let position = (cut_offset << 3u) + (lit.node >> 16u);
    if position > (*cursor).position {
        var texel = visibility_texel(position >> 3u);
        for (var i = 0u; i < (position & 7u); i += 1u) {
            texel = shifted(texel);
        }
        *cursor = Cursor(texel, position, lit.end - lit_size(lit.node) + cursor_size(texel));
    }
    while (*cursor).end <= leaf {
        advance_visibility(cursor);
    }
}
