// Materials and their textures. All textures lie in one pool of 32-bit words, so that any number of them of any size
// needs one binding; lookups are bilinear with repeat, and filter after decoding. Twin of core/src/texture.rs.

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
    channel: u32,
}

// A declared parameter of a model: the value of a material, and the map that modulates it.
struct MaterialParameter {
    value: vec3<f32>,
    padding: u32,
    map: TextureSlot,
}

// In place of a measured BRDF that is not there.
const NO_TABLE: u32 = 0xffffffffu;

// Most parameters of a model.
const MOST_PARAMETERS: u32 = 32u;

struct Material {
    model: u32,
    // -1 if the normal map has green down, else 1.
    normal_y: f32,
    // First word of its measured BRDF.
    table: u32,
    padding: u32,
    // Albedo for light from the normal, and width of the lobe, of a BRDF that is known by its values.
    estimate: vec4<f32>,
    normal_map: TextureSlot,
    bump_map: TextureSlot,
    // In the order in which the model declares them.
    parameters: array<MaterialParameter, MOST_PARAMETERS>,
}

// One word per texel, 8 bits per component.
const KIND_LINEAR: u32 = 1u;
// The same, sRGB encoded.
const KIND_SRGB: u32 = 2u;
// Four words a texel.
const KIND_FLOAT: u32 = 3u;

// The pool is this wide, as a power of two.
const POOL_WIDTH_LOG2: u32 = 13u;

@group(1) @binding(2) var<storage, read> materials: array<Material>;
@group(1) @binding(3) var pool: texture_2d<u32>;
struct Tables {
    // Linear values of the 256 sRGB codes.
    linear_from_srgb: array<vec4<f32>, 64>,
    // See Albedo in brdf.wgsl: two for each width of each lobe.
    albedo: array<vec4<f32>, 608>,
}

@group(1) @binding(4) var<uniform> tables: Tables;

fn pool_word(index: u32) -> u32 {
    let position = vec2(index & ((1u << POOL_WIDTH_LOG2) - 1u), index >> POOL_WIDTH_LOG2);
    return textureLoad(pool, position, 0).x;
}

fn decode_srgb(code: u32) -> f32 {
    return tables.linear_from_srgb[code >> 2u][code & 3u];
}

fn texel(slot: TextureSlot, x: u32, y: u32) -> vec4<f32> {
    let index = y * slot.width + x;
    if slot.kind == KIND_FLOAT {
        let first = slot.first + 4u * index;
        let words = vec4(pool_word(first), pool_word(first + 1u), pool_word(first + 2u), pool_word(first + 3u));
        return bitcast<vec4<f32>>(words);
    }
    let word = pool_word(slot.first + index);
    let codes = vec4(word & 255u, (word >> 8u) & 255u, (word >> 16u) & 255u, word >> 24u);
    let linear = vec4<f32>(codes) / 255.0;
    if slot.kind == KIND_SRGB {
        return vec4(decode_srgb(codes.x), decode_srgb(codes.y), decode_srgb(codes.z), linear.w);
    }
    return linear;
}

// Texture coordinates after the slot's transform.
fn transform_uv(slot: TextureSlot, uv: vec2<f32>) -> vec2<f32> {
    let s = uv * slot.scale;
    return vec2(slot.turn.y * s.x + slot.turn.x * s.y, -slot.turn.x * s.x + slot.turn.y * s.y) + slot.offset;
}

// Bilinear lookup with repeat of transformed coordinates.
fn sample_texture(slot: TextureSlot, uv: vec2<f32>) -> vec4<f32> {
    let size = vec2(slot.width, slot.height);
    let p = (uv - floor(uv)) * vec2<f32>(size) - 0.5;
    let f = p - floor(p);
    // -1 to size - 1, wrapped.
    let low = vec2<u32>(vec2<i32>(floor(p)) + vec2<i32>(size)) % size;
    let high = (low + 1u) % size;
    let top = mix(texel(slot, low.x, low.y), texel(slot, high.x, low.y), f.x);
    let bottom = mix(texel(slot, low.x, high.y), texel(slot, high.x, high.y), f.x);
    return mix(top, bottom, f.y);
}

fn sample_slot(slot: TextureSlot, uv: vec2<f32>) -> vec4<f32> {
    return sample_texture(slot, transform_uv(slot, uv));
}

// A colour of a material after its map, within the parameter's range. Twin of `Material::values` in core/src/material.rs.
fn material_color(material: u32, index: u32, uv: vec2<f32>, range: vec2<f32>, least: f32) -> vec3<f32> {
    let value = materials[material].parameters[index].value;
    let map = materials[material].parameters[index].map;
    if map.kind == 0u {
        return clamp(value, vec3(range.x), vec3(range.y));
    }
    return clamp(least + (value - least) * sample_slot(map, uv).xyz, vec3(range.x), vec3(range.y));
}

// The same of a number. What is above `least` is scaled by the map.
fn material_number(material: u32, index: u32, uv: vec2<f32>, range: vec2<f32>, least: f32) -> f32 {
    let value = materials[material].parameters[index].value.x;
    let map = materials[material].parameters[index].map;
    if map.kind == 0u {
        return clamp(value, range.x, range.y);
    }
    return clamp(least + (value - least) * sample_slot(map, uv)[map.channel], range.x, range.y);
}
