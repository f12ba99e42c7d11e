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

// A position in a cut.
struct Cursor {
    // The nodes from the current one on, as far as the texel reaches; the current one in the low bits of x.
    texel: vec4<u32>,
    // Index of the current node in the whole texture.
    position: u32,
    // One past the last leaf of the current node.
    end: u32,
}

fn visibility_texel(index: u32) -> vec4<u32> {
    return textureLoad(visibility_cuts, vec2(index & ((1u << CUT_WIDTH_LOG2) - 1u), index >> CUT_WIDTH_LOG2), 0);
}

fn illumination_texel(index: u32) -> vec4<u32> {
    return textureLoad(illumination_cut, vec2(index & ((1u << CUT_WIDTH_LOG2) - 1u), index >> CUT_WIDTH_LOG2), 0);
}

// Leaves below the current node.
fn cursor_size(texel: vec4<u32>) -> u32 {
    return 1u << (tree_height() - ((texel.x >> 12u) & 15u));
}

fn cursor_value(cursor: Cursor) -> f32 {
    return value_of_code(cursor.texel.x & 4095u);
}

fn value_of_code(code: u32) -> f32 {
    if FIELD != FIELD_SOURCES {
        return f32(code) * VALUE_SCALE;
    }
    return select(LARGEST_SOLID_ANGLE * exp2(f32(code - 1u) * ORDERS_PER_CODE - ORDERS), 0.0, code == 0u);
}

// The texel without its first node.
fn shifted(texel: vec4<u32>) -> vec4<u32> {
    return (texel >> vec4(16u)) | (vec4(texel.yzw, 0u) << vec4(16u));
}

fn visibility_cursor(offset: u32) -> Cursor {
    let texel = visibility_texel(offset);
    return Cursor(texel, offset << 3u, cursor_size(texel));
}

fn illumination_cursor() -> Cursor {
    let texel = illumination_texel(0u);
    return Cursor(texel, 0u, cursor_size(texel));
}

fn advance_visibility(cursor: ptr<function, Cursor>) {
    (*cursor).position += 1u;
    if ((*cursor).position & 7u) == 0u {
        (*cursor).texel = visibility_texel((*cursor).position >> 3u);
    } else {
        (*cursor).texel = shifted((*cursor).texel);
    }
    (*cursor).end += cursor_size((*cursor).texel);
}

fn advance_illumination(cursor: ptr<function, Cursor>) {
    (*cursor).position += 1u;
    if ((*cursor).position & 7u) == 0u {
        (*cursor).texel = illumination_texel((*cursor).position >> 3u);
    } else {
        (*cursor).texel = shifted((*cursor).texel);
    }
    (*cursor).end += cursor_size((*cursor).texel);
}
