// Materials and their textures. All textures are in one pool of 32-bit words, so that any number of any size needs one binding.
// Each is followed by its levels of detail. Lookups take the mean within a footprint, after decoding. Twin of
// core/src/texture.rs.

struct TextureSlot {
    // First word in the pool.
    first: u32,
    width: u32,
    height: u32,
    // 0: no texture; else see KIND_*.
    kind: u32,
    scale: vec2<f32>,
    offset: vec2<f32>,
    // Sine and cosine of the rotation.
    turn: vec2<f32>,
    strength: f32,
    // Bits 0 and 1: component; 2 and 3: WRAP_* along u; 4 and 5: along v; 6: set of texture coordinates; 7: normals have green
    // down.
    lookup: u32,
    // Pattern: its values, kind (see PATTERN_*), and octaves of noise.
    low: vec3<f32>,
    pattern: u32,
    high: vec3<f32>,
    octaves: u32,
}

// A model's declared parameter: a material's value and the map that modulates it.
struct MaterialParameter {
    value: vec3<f32>,
    // 1 if the colors of the vertices multiply it.
    has_vertex_color: u32,
    map: TextureSlot,
}

// Table of a missing measured BRDF.
const NO_TABLE: u32 = 0xffffffffu;

// Most parameters of a model.
const MOST_PARAMETERS: u32 = 32u;
const MOST_LUMINANCE: f32 = 1e6;

struct Material {
    model: u32,
    // READS_*: what it needs of the vertices.
    reads: u32,
    // Index of the first surface parameter; all models have these.
    surface: u32,
    // First word of its measured BRDF.
    table: u32,
    // Albedo for light from the normal and width of the lobe, for a tabulated or written BRDF.
    estimate: vec4<f32>,
    normal_map: TextureSlot,
    bump_map: TextureSlot,
    // In the model's declared order.
    parameters: array<MaterialParameter, MOST_PARAMETERS>,
}

// One word per texel, 8 bits per component.
const KIND_LINEAR: u32 = 1u;
// One word per texel, 8 bits per component, sRGB encoded.
const KIND_SRGB: u32 = 2u;
// Four words per texel.
const KIND_FLOAT: u32 = 3u;
// A pattern without texels.
const KIND_PROCEDURAL: u32 = 4u;

// Width of the pool, as a power of two.
const POOL_WIDTH_LOG2: u32 = 13u;

@group(1) @binding(2) var<storage, read> materials: array<Material>;
@group(1) @binding(3) var pool: texture_2d<u32>;
@group(1) @binding(4) var<uniform> tables: Tables;

fn pool_word(index: u32) -> u32 {
    let position = vec2(index & ((1u << POOL_WIDTH_LOG2) - 1u), index >> POOL_WIDTH_LOG2);
    return textureLoad(pool, position, 0).x;
}

fn decode_srgb(code: u32) -> f32 {
    return tables.linear_from_srgb[code >> 2u][code & 3u];
}

// A level of a texture in the pool; the texture itself is level 0.
struct Level {
    first: u32,
    size: vec2<u32>,
}

fn texel_words(slot: TextureSlot) -> u32 {
    return select(1u, 4u, slot.kind == KIND_FLOAT);
}

// A level whose texels take `words` words, as in all levels but 0.
fn level_of(slot: TextureSlot, level: u32, words: u32) -> Level {
    var there = Level(slot.first, vec2(slot.width, slot.height));
    var texel_size = texel_words(slot);
    for (var i = 0u; i < level; i++) {
        there.first += texel_size * there.size.x * there.size.y;
        there.size = max(there.size >> vec2(1u), vec2(1u));
        texel_size = words;
    }
    return there;
}

// The level with a single texel.
fn last_level(slot: TextureSlot) -> u32 {
    return firstLeadingBit(max(slot.width, slot.height));
}

fn texel(kind: u32, level: Level, x: u32, y: u32) -> vec4<f32> {
    let index = y * level.size.x + x;
    if kind == KIND_FLOAT {
        let first = level.first + 4u * index;
        let words = vec4(pool_word(first), pool_word(first + 1u), pool_word(first + 2u), pool_word(first + 3u));
        return bitcast<vec4<f32>>(words);
    }
    let word = pool_word(level.first + index);
    let codes = vec4(word & 255u, (word >> 8u) & 255u, (word >> 16u) & 255u, word >> 24u);
    let linear = vec4<f32>(codes) / 255.0;
    if kind == KIND_SRGB {
        return vec4(decode_srgb(codes.x), decode_srgb(codes.y), decode_srgb(codes.z), linear.w);
    }
    return linear;
}

// The linear part of a slot's transform: a column of the matrix.
fn linear_column(slot: TextureSlot, axis: u32) -> vec2<f32> {
    if axis == 0u {
        return vec2(slot.turn.y, -slot.turn.x) * slot.scale.x;
    }
    return vec2(slot.turn.x, slot.turn.y) * slot.scale.y;
}

// The picture's axes on the surface: what a normal's x and y in the picture add along tangent and bitangent. Twin of
// `TextureSlot::normal_axes`.
fn normal_axes(slot: TextureSlot) -> mat2x2<f32> {
    let green = select(1.0, -1.0, (slot.lookup & 128u) != 0u);
    let mirror = slot.strength * select(vec2(1.0), vec2(-1.0), slot.scale < vec2(0.0));
    return mat2x2<f32>(mirror * vec2(slot.turn.y, -slot.turn.x), green * mirror * slot.turn);
}

// Texture coordinates after the slot's transform.
fn transform_uv(slot: TextureSlot, uv: vec2<f32>) -> vec2<f32> {
    let s = uv * slot.scale;
    return vec2(slot.turn.y * s.x + slot.turn.x * s.y, -slot.turn.x * s.x + slot.turn.y * s.y) + slot.offset;
}

// The four texels around a point, and the weights of the right and the lower ones.
struct Quad {
    low: vec2<u32>,
    high: vec2<u32>,
    blend: vec2<f32>,
}

fn quad_around(size: vec2<u32>, uv: vec2<f32>, lookup: u32) -> Quad {
    let wrap = vec2(lookup >> 2u, lookup >> 4u) & vec2(3u);
    let p = vec2(folded(uv.x, wrap.x), folded(uv.y, wrap.y)) * vec2<f32>(size) - 0.5;
    // -1 to size - 1, and its neighbor, repeated or held at the edges.
    let first = vec2<i32>(floor(p));
    let last = vec2<i32>(size) - 1;
    let low = select(clamp(first, vec2(0), last), (first + last + 1) % (last + 1), wrap == vec2(WRAP_REPEAT));
    let high = select(clamp(first + 1, vec2(0), last), (low + 1) % (last + 1), wrap == vec2(WRAP_REPEAT));
    return Quad(vec2<u32>(low), vec2<u32>(high), p - floor(p));
}

const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRROR: u32 = 1u;
const WRAP_CLAMP: u32 = 2u;

fn channel_of(slot: TextureSlot) -> u32 {
    return slot.lookup & 3u;
}

// How coordinates outside 0 to 1 are read, along u or v.
fn wrap_of(slot: TextureSlot, axis: u32) -> u32 {
    return (slot.lookup >> (2u + 2u * axis)) & 3u;
}

fn uv_set_of(slot: TextureSlot) -> u32 {
    return (slot.lookup >> 6u) & 1u;
}

// The coordinate within 0 to 1 that shows the same. Twin of core/src/texture/wrap.rs.
fn folded(t: f32, wrap: u32) -> f32 {
    if wrap == WRAP_CLAMP {
        return clamp(t, 0.0, 1.0);
    }
    if wrap == WRAP_MIRROR {
        let within_two = t - 2.0 * floor(0.5 * t);
        return min(within_two, 2.0 - within_two);
    }
    return t - floor(t);
}

// The derivative of `folded`.
fn folded_slope(t: f32, wrap: u32) -> f32 {
    if wrap == WRAP_CLAMP {
        return select(0.0, 1.0, t >= 0.0 && t <= 1.0);
    }
    return select(1.0, -1.0, wrap == WRAP_MIRROR && t - 2.0 * floor(0.5 * t) >= 1.0);
}

// Bilinear lookup of transformed coordinates.
fn sample_level(slot: TextureSlot, level: Level, uv: vec2<f32>) -> vec4<f32> {
    let quad = quad_around(level.size, uv, slot.lookup);
    let low = quad.low;
    let high = quad.high;
    let top = mix(texel(slot.kind, level, low.x, low.y), texel(slot.kind, level, high.x, low.y), quad.blend.x);
    let bottom = mix(texel(slot.kind, level, low.x, high.y), texel(slot.kind, level, high.x, high.y), quad.blend.x);
    return mix(top, bottom, quad.blend.y);
}

// Bilinear lookup in the texture itself.
fn sample_texture(slot: TextureSlot, uv: vec2<f32>) -> vec4<f32> {
    return sample_level(slot, Level(slot.first, vec2(slot.width, slot.height)), uv);
}

// The lookups of a footprint. Twin of core/src/texture/footprint.rs.
struct Taps {
    count: u32,
    first: vec2<f32>,
    step: vec2<f32>,
    level: f32,
}

const MOST_TAPS: f32 = 8.0;
const TEXELS_PER_WIDTH: f32 = 1.7320508;

fn is_point(taps: Taps) -> bool {
    return taps.level <= 0.0 && taps.count == 1u;
}

fn taps_of(slot: TextureSlot, footprint: UvFootprint) -> Taps {
    let uv = transform_uv(slot, footprint.uv);
    let point = Taps(1u, uv, vec2(0.0), 0.0);
    let size = vec2(f32(slot.width), f32(slot.height));
    let turn = mat2x2<f32>(linear_column(slot, 0u), linear_column(slot, 1u));
    let a = turn * footprint.right * size;
    let b = turn * footprint.below * size;
    // The ellipse has the axes of J J^T.
    let m = vec3(a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
    let half = 0.5 * (m.x - m.z);
    let root = sqrt(half * half + m.y * m.y);
    let long = sqrt(0.5 * (m.x + m.z) + root);
    if !(long > TEXELS_PER_WIDTH && long < 1e18) {
        return point;
    }
    let short = abs(a.x * b.y - a.y * b.x) / long;
    let along = select(vec2(m.y, root - half), vec2(half + root, m.y), half > 0.0);
    let axis = along * (long / max(length(along), 1e-20)) / size;
    // Not finer than texels.
    let width = max(short, TEXELS_PER_WIDTH);
    let count = clamp(floor(long / width + 0.5), 1.0, MOST_TAPS);
    let step = axis / count;
    // A quotient of 1 may come out as less where division is not correctly rounded.
    let level = max(log2(max(width, long / count) / TEXELS_PER_WIDTH), 0.0);
    return Taps(u32(count), uv - step * (0.5 * (count - 1.0)), step, level);
}

// The mean within a footprint.
fn sample_slot(slot: TextureSlot, footprint: UvFootprint) -> vec4<f32> {
    if slot.kind == KIND_PROCEDURAL {
        return procedural_value(slot, through_slot(slot, footprint));
    }
    let taps = taps_of(slot, footprint);
    let level = min(taps.level, f32(last_level(slot)));
    let blend = fract(level);
    let words = texel_words(slot);
    var sum = vec4(0.0);
    // For each tap the finer and the coarser level.
    for (var i = 0u; i < 2u * taps.count; i++) {
        let weight = select(1.0 - blend, blend, (i & 1u) != 0u);
        if weight > 0.0 {
            let there = level_of(slot, u32(level) + (i & 1u), words);
            sum += weight * sample_level(slot, there, taps.first + taps.step * f32(i >> 1u));
        }
    }
    return sum / f32(taps.count);
}

// A color of a material without a map, within the parameter's range.
fn plain_color(material: u32, index: u32, range: vec2<f32>) -> vec3<f32> {
    return clamp(materials[material].parameters[index].value, vec3(range.x), vec3(range.y));
}

// A number of a material without a map, within the parameter's range.
fn plain_number(material: u32, index: u32, range: vec2<f32>) -> f32 {
    return clamp(materials[material].parameters[index].value.x, range.x, range.y);
}

// The coordinates that a slot transforms.
fn uv_of(slot: TextureSlot, at: SurfaceAttributes) -> UvFootprint {
    if uv_set_of(slot) == SECOND_UVS {
        return at.second_uv;
    }
    return at.uv;
}

// A color of a material after its map and the colors of the vertices, within the parameter's range. Twin of `ResolvedMaterial::values` in core/src/material/resolved.rs.
fn material_color(material: u32, index: u32, at: SurfaceAttributes, range: vec2<f32>, least: f32) -> vec3<f32> {
    let value = materials[material].parameters[index].value;
    let map = materials[material].parameters[index].map;
    let has_vertex_color = materials[material].parameters[index].has_vertex_color != 0u;
    if map.kind == 0u && !has_vertex_color {
        return plain_color(material, index, range);
    }
    var factor = vec3(1.0);
    if map.kind != 0u {
        factor = sample_slot(map, uv_of(map, at)).xyz;
    }
    if has_vertex_color {
        factor *= at.color;
    }
    return clamp(least + (value - least) * factor, vec3(range.x), vec3(range.y));
}

// A number of a material after its map. The part above `least` is scaled by the map.
fn material_number(material: u32, index: u32, at: SurfaceAttributes, range: vec2<f32>, least: f32) -> f32 {
    let value = materials[material].parameters[index].value.x;
    let map = materials[material].parameters[index].map;
    if map.kind == 0u {
        return plain_number(material, index, range);
    }
    return clamp(least + (value - least) * sample_slot(map, uv_of(map, at))[channel_of(map)], range.x, range.y);
}

// Radiance emitted by a material. Twin of `SurfaceParameters` in core/src/brdf/surface.rs.
fn material_emission(material: u32, at: SurfaceAttributes) -> vec3<f32> {
    let first = materials[material].surface;
    if materials[material].parameters[first].value.x == 0.0 {
        return vec3(0.0);
    }
    let luminance = material_number(material, first, at, vec2(0.0, MOST_LUMINANCE), 0.0);
    return material_color(material, first + 1u, at, vec2(0.0, 1.0), 0.0) * luminance;
}
