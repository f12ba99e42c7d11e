// Cuts as they are stored: 16 bits per node (depth << 12 | value), eight nodes per texel. Twin of core/src/cut/packed.rs.

// Cuts of all vertices, of visibility or of solid angles; each starts at a texel.
@group(2) @binding(2) var visibility_cuts: texture_2d<u32>;
// The illumination cut.
@group(2) @binding(3) var illumination_cut: texture_2d<u32>;

// Texels in one row of both textures, as a power of two.
const CUT_WIDTH_LOG2: u32 = 13u;
const VALUE_SCALE: f32 = 1.0 / 4095.0;
// The code of solid angles, see core/src/cut/solid_angles/code.rs: the largest, and binary orders of magnitude a step.
const LARGEST_SOLID_ANGLE: f32 = 6.2831855;
const ORDERS: f32 = 30.0;
const ORDERS_PER_CODE: f32 = 30.0 / 4094.0;

// A position in a cut, in as few registers as can be: with more in each, fewer groups of threads are in flight. Nodes lie at multiples of
// their size, so that any leaf below one tells where it begins and ends.
struct Cursor {
    // The current node, in the low half.
    node: u32,
    // Its index in the whole texture or array.
    position: u32,
}

fn visibility_texel(index: u32) -> vec4<u32> {
    return textureLoad(visibility_cuts, vec2(index & ((1u << CUT_WIDTH_LOG2) - 1u), index >> CUT_WIDTH_LOG2), 0);
}

fn illumination_texel(index: u32) -> vec4<u32> {
    return textureLoad(illumination_cut, vec2(index & ((1u << CUT_WIDTH_LOG2) - 1u), index >> CUT_WIDTH_LOG2), 0);
}

// A node of a texel, by its index.
fn node_in(texel: vec4<u32>, position: u32) -> u32 {
    return (texel[(position >> 1u) & 3u] >> (16u * (position & 1u))) & 0xffffu;
}

fn node_depth(node: u32) -> u32 {
    return (node >> 12u) & 15u;
}

// Leaves below a node.
fn leaves_below(node: u32) -> u32 {
    return 1u << (tree_height() - node_depth(node));
}

// First leaf of a node that has a leaf.
fn begin_of(node: u32, leaf: u32) -> u32 {
    return leaf & ~(leaves_below(node) - 1u);
}

// One past its last leaf.
fn end_of(node: u32, leaf: u32) -> u32 {
    return (leaf | (leaves_below(node) - 1u)) + 1u;
}

fn cursor_value(cursor: Cursor) -> f32 {
    return value_of_code(cursor.node & 4095u);
}

fn value_of_code(code: u32) -> f32 {
    if FIELD != FIELD_SOURCES {
        return f32(code) * VALUE_SCALE;
    }
    return select(LARGEST_SOLID_ANGLE * exp2(f32(code - 1u) * ORDERS_PER_CODE - ORDERS), 0.0, code == 0u);
}

fn visibility_cursor(position: u32) -> Cursor {
    return Cursor(node_in(visibility_texel(position >> 3u), position), position);
}

fn illumination_cursor(position: u32) -> Cursor {
    return Cursor(node_in(illumination_texel(position >> 3u), position), position);
}
