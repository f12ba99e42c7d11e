// The mesh, with the place of each vertex's cuts.

struct Vertex {
    position: vec3<f32>,
    // First texel of the vertex's cut.
    cut_offset: u32,
    normal: vec3<f32>,
    // Number of nodes of the cut.
    cut_len: u32,
    tangent: vec3<f32>,
    // Sign of the tangent frame: bitangent = handedness * normal x tangent.
    handedness: f32,
    uv: vec2<f32>,
    // 0 for vertices inside other geometry, which interpolation ignores.
    is_valid: u32,
    // First texel of the vertex's cut over surface sources.
    source_cut_offset: u32,
    second_uv: vec2<f32>,
    // Three fractions of 16 bits.
    color: vec2<u32>,
}

struct Triangle {
    vertices: vec3<u32>,
    // Bit 31: lit and visible from both sides; the rest: index of the material.
    material: u32,
}

const TWO_SIDED: u32 = 0x80000000u;

@group(1) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(1) @binding(1) var<storage, read> triangles: array<Triangle>;
