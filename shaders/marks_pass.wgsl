// Surfaces in each pixel's samples: sets of materials and of vertex patches, by index modulo 64. Twin of `Marks` in
// render/src/stale.rs.

// The patch of each vertex, or a single one if patches are not used.
@group(2) @binding(0) var<storage, read> patches: array<u32>;
@group(3) @binding(0) var triangle_ids: texture_2d<u32>;
@group(3) @binding(1) var previous_marks: texture_2d<u32>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<u32> {
    let pixel = vec2<u32>(position.xy);
    let marks = textureLoad(previous_marks, pixel, 0);
    let id = textureLoad(triangle_ids, pixel, 0).x;
    if id == 0u {
        return marks;
    }
    let triangle = triangles[id - 1u];
    let v = triangle.vertices;
    return marks | vec4(bit(triangle.material & ~TWO_SIDED), bit(patch_of(v.x)) | bit(patch_of(v.y)) | bit(patch_of(v.z)));
}

fn patch_of(vertex: u32) -> u32 {
    return patches[min(vertex, arrayLength(&patches) - 1u)];
}

// One of 64 bits, the low word first.
fn bit(index: u32) -> vec2<u32> {
    let one = 1u << (index & 31u);
    return select(vec2(one, 0u), vec2(0u, one), (index & 32u) != 0u);
}
