// Unblocked directions from many origins: one workgroup for each 64 directions of an origin, which writes two words of bits.

struct RayUniforms {
    directions: u32,
    // Words of bits per origin.
    words: u32,
}

@group(1) @binding(0) var<uniform> rays: RayUniforms;
@group(1) @binding(1) var<storage, read> directions: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read> origins: array<RayOrigin>;
@group(1) @binding(3) var<storage, read_write> open_words: array<u32>;

var<workgroup> bits: array<atomic<u32>, 2>;

@compute @workgroup_size(64)
fn trace(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = 64u * group.x + lane;
    if index < rays.directions {
        let at = origins[group.y];
        let direction = directions[index].xyz;
        if is_wanted(direction, at) && !is_occluded(at.origin, direction) {
            atomicOr(&bits[lane / 32u], 1u << (lane % 32u));
        }
    }
    workgroupBarrier();
    let word = 2u * group.x + lane;
    if lane < 2u && word < rays.words {
        open_words[group.y * rays.words + word] = atomicLoad(&bits[lane]);
    }
}
